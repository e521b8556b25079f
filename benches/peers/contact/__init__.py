"""The second part of `make peers`: engines on scenes in which cloth touches bodies and itself."""
