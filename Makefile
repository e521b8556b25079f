# `make demo` shows taut, `make test` checks it; each does all the set-up it needs.
PYTHON ?= python3
BIN := .venv/bin
EXAMPLES := $(basename $(notdir $(wildcard crates/taut/examples/*.rs)))
RUST_SOURCES := $(shell find crates -name '*.rs' -o -name Cargo.toml) Cargo.toml Cargo.lock

# The engine is tested as it is shipped, and with the features of the Python module: so it is built once for the tests of both. What looks
# at it without building it (clippy, rustdoc) takes the same profile for the sake of macros and build scripts.
SHIPPED := --release --features taut-python/extension-module

# Two at a time keep both cores busy where one of them links, or waits for the network; each then says what it has to say at its end.
TOGETHER := --jobs=2 $(if $(filter output-sync,$(.FEATURES)),--output-sync=target)

.PHONY: setup demo test test-rust test-python lint lint-rust lint-python lint-stubs package bench targets peers schema figures compare viewer-pictures wind work-precision local-correction drape docs gallery wheel attack sanitize fuzz clean
.DEFAULT_GOAL := demo

setup: .venv/built

.venv/ready: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "taut needs Python 3.11 or newer, this is " + sys.version.split()[0])'
	@command -v cargo > /dev/null || { echo "taut needs Rust (cargo): see https://rustup.rs"; exit 1; }
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --upgrade pip 'maturin>=1.9,<2' 'uv>=0.9,<1'
	@$(BIN)/uv pip install --quiet --python $(BIN)/python --requirements pyproject.toml --extra dev --extra docs \
		|| echo "uv could not install the packages, pip will (it takes a minute longer)"
	@touch $@

.venv/built: .venv/ready $(RUST_SOURCES)
	PIP_QUIET=1 $(BIN)/maturin develop --release --quiet --extras dev,docs
	@touch $@

demo: setup
	$(BIN)/python tools/demo.py

# In the order in which one core has something to do while the other one builds the engine.
test:
	@$(MAKE) --no-print-directory $(TOGETHER) lint-rust .venv/ready
	@$(MAKE) --no-print-directory $(TOGETHER) setup lint-python lint-stubs test-rust test-python

lint: lint-rust lint-python lint-stubs

# rustfmt sees every file: the modules that a macro in lib.rs declares are hidden from cargo fmt.
lint-rust:
	cargo fmt --check
	@rustfmt --check --edition 2024 $(filter %.rs,$(RUST_SOURCES)) benches/engine/*.rs
	cargo clippy --quiet --release --workspace --all-targets -- --deny warnings

lint-python: .venv/ready
	$(BIN)/ruff check --quiet .
	$(BIN)/ruff format --quiet --check .
	$(BIN)/mypy
	$(BIN)/python tools/check_house.py
	$(BIN)/check-jsonschema --quiet --builtin-schema vendor.github-workflows .github/workflows/*.yml
	$(BIN)/check-jsonschema --quiet --builtin-schema vendor.citation-file-format --force-filetype yaml CITATION.cff
	$(BIN)/zizmor --quiet --offline .github
	tools/check_js.sh

lint-stubs: setup
	$(BIN)/stubtest taut._taut

# The examples run as well; the crate builds without its features, its reference has no warning, and it can be packaged. Where a
# feature brings much to build and nothing to read, it is off.
test-rust:
	cargo test --quiet $(SHIPPED)
	for example in $(EXAMPLES); do cargo run --quiet $(SHIPPED) --example $$example || exit 1; done
	cargo clippy --quiet --release --package taut --no-default-features -- --deny warnings
	RUSTDOCFLAGS='--deny warnings' cargo doc --quiet --release --package taut --no-deps --no-default-features --features json,threads
	cargo package --quiet --package taut --allow-dirty --no-verify --offline

# The crate, built from what would be published.
package:
	cargo package --package taut --allow-dirty

test-python: setup
	$(BIN)/pytest --quiet --numprocesses auto --dist loadfile --no-loadscope-reorder

# Attacks taut at its promises (docs/reliability.md): MINUTES=60, SEED=1 for other cases, ONLY=whole for one of them.
attack: setup
	$(BIN)/python -m tests.attack --minutes $(or $(MINUTES),60) --seed $(or $(SEED),1) $(if $(ONLY),--only $(ONLY)) $(if $(WRITE),--write)

# Miri and ThreadSanitizer over the engine's own tests, where a nightly compiler with both is there (docs/reliability.md).
sanitize:
	tools/sanitize.sh

# Fuzzes the readers of the engine (fuzz/README.md): MINUTES=5 each.
fuzz:
	for target in scene model snapshot; do cargo +nightly fuzz run $$target -- -max_total_time=$$(( 60 * $(or $(MINUTES),5) )) || exit 1; done

bench: setup
	cargo bench --package taut-benches
	$(BIN)/taut bench --compare

# All rows, into docs/targets.md; with ROW=name one of them, to the terminal, with WRITE=1 as well into that page. An error if one is
# not met.
targets: setup
	$(BIN)/python -m tools.targets $(if $(ROW),--only $(ROW) $(if $(WRITE),--write),--write)

peers: setup
	$(BIN)/python benches/peers/run.py

schema: setup
	$(BIN)/taut schema > docs/scene.schema.json

# The site, in out/site; warnings are errors, and nothing is fetched. The tests build it, too.
docs: setup
	$(BIN)/python -m tools.site

# Films of the shipped scenes for the site, and the stills of its gallery.
gallery: setup
	$(BIN)/python tools/gallery.py

# A wheel, installed where nothing of this folder is in reach, runs what it brings.
wheel: setup
	rm -rf out/wheel
	$(BIN)/maturin build --release --quiet --out out/wheel
	$(PYTHON) -m venv out/wheel/venv
	out/wheel/venv/bin/pip install --quiet out/wheel/*.whl
	cd out/wheel && venv/bin/taut scenes && venv/bin/taut run cape --out cape.zarr --frames 10

figures: setup
	$(BIN)/python tools/figures.py

compare: setup
	$(BIN)/python tools/compare.py

# The page of `taut view`, in Chromium.
viewer-pictures: setup
	$(BIN)/python tools/viewer_pictures.py

local-correction: setup
	$(BIN)/python -m tools.local_correction

wind: setup
	$(BIN)/python tools/wind.py

drape: setup
	$(BIN)/python tools/drape.py $(if $(ONLY),--only $(ONLY))

work-precision: setup
	$(BIN)/python tools/work_precision.py

clean:
	rm -rf .venv target out
