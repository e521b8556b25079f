//! What happened, as Python sees it.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use taut::advance::Summary;

/// `Report` of `_taut.pyi`.
pub fn report<'py>(py: Python<'py>, summary: &Summary, time: f64) -> PyResult<Bound<'py, PyDict>> {
    let spring = |index: Option<u32>| index.map_or(-1, i64::from);
    let last = &summary.last;
    let report = PyDict::new(py);
    report.set_item("time", time)?;
    report.set_item("steps", summary.steps)?;
    report.set_item("evaluations", summary.evaluations)?;
    report.set_item("worst_stretch", last.worst_stretch)?;
    report.set_item("worst_spring", spring(last.worst_spring))?;
    report.set_item("worst_stretch_in_steps", summary.worst_stretch)?;
    report.set_item("worst_spring_in_steps", spring(summary.worst_spring))?;
    report.set_item("limited_steps", summary.limited_steps)?;
    report.set_item("limited_springs", summary.limited_springs)?;
    report.set_item("sweeps", summary.sweeps)?;
    report.set_item("cuts", summary.cuts)?;
    report.set_item("held_back_pins", summary.held_back_pins)?;
    report.set_item("pinched", summary.pinched)?;
    report.set_item("held_back_bodies", summary.held_back_bodies)?;
    report.set_item("lost_motion", summary.lost_motion)?;
    report.set_item("mean_lost_motion", summary.mean_lost_motion)?;
    report.set_item("contacts", summary.contacts)?;
    report.set_item("contact_cuts", summary.contact_cuts)?;
    report.set_item("halved_steps", summary.halved_steps)?;
    report.set_item("closest", summary.closest.unwrap_or(f64::INFINITY))?;
    report.set_item("penetrations", summary.penetrations)?;
    report.set_item("asleep", summary.asleep)?;
    report.set_item("repaired_momentum", summary.repaired_momentum.to_array())?;
    report.set_item("detection_ms", 1e3 * summary.times.detection)?;
    report.set_item("solve_ms", 1e3 * summary.times.solve)?;
    report.set_item("certificate_ms", 1e3 * summary.times.certificate)?;
    report.set_item("kinetic_energy", last.kinetic_energy)?;
    report.set_item("elastic_energy", last.elastic_energy)?;
    report.set_item("potential_energy", last.potential_energy)?;
    Ok(report)
}
