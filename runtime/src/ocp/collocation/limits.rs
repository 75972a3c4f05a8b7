//! What the motion has to keep between the stages.

use super::discretization::Setting;
use crate::ocp::settings::Settings;

/// Gap below which a flight counts as touching, relative to the gap margin.
const TOUCHING: f64 = 0.1;

/// What to look for between the stages.
#[derive(Clone, Copy)]
pub(in crate::ocp) struct Limits<'a> {
    /// Gaps below this are grazing or penetrating, by their shares.
    pub(super) gap: f64,
    /// Gap that a cut asks for, by its share.
    margin: f64,
    /// Largest violation of a bound of a coordinate, in its unit, that is let pass.
    pub(super) bound: f64,
    pub(super) setting: Setting<'a>,
}

impl<'a> Limits<'a> {
    pub(in crate::ocp) fn new(setting: Setting<'a>, settings: &Settings) -> Self {
        Self {
            gap: touching_gap(settings),
            margin: settings.gap_margin,
            bound: settings.tolerance,
            setting,
        }
    }

    /// Gap of a contact below which it is grazing or penetrating.
    pub(super) fn gap_of(&self, contact: usize) -> f64 {
        self.gap * self.setting.units.share_of_gap(contact)
    }

    /// Gap of a contact that a cut asks for.
    pub(super) fn margin_of(&self, contact: usize) -> f64 {
        self.margin * self.setting.units.share_of_gap(contact)
    }
}

/// Gap below which a flight counts as touching \[unit of the gap, by its share\].
pub(in crate::ocp) fn touching_gap(settings: &Settings) -> f64 {
    TOUCHING * settings.gap_margin
}
