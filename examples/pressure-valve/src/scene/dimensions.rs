//! Dimensions of a pressure valve, quantities derived from them, and rules that they must keep.

use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use tremie_messages::units::{Angle, Density, Length, Mass, Pressure, Velocity};

/// Dimensions of a valve, in the valve's frame: y along its axis, zero on the flat of the seat and
/// up with the lift; z along the conduit, in the direction of the flow; the plane x = 0 a mirror.
///
/// Radii of the rubber, slope of the cone, lip and moving mass are those that Mutabaruka and Kamrin
/// (*Comput. Part. Mech.* 5, 2018) state; the rest stands in drawings of theirs that were not
/// available, and was chosen to fit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Dimensions {
    /// Radius of the conduit and of the bore that leads from it to the seat.
    pub bore_radius: Length,
    /// Height y of the conduit's axis.
    pub conduit_axis: Length,
    /// Begin of the conduit, along z.
    pub inlet: Length,
    /// End of the conduit with a pressure closure, along z.
    pub blind_end: Length,
    /// Closure at the conduit's end.
    pub closure: Closure,
    /// Safety closure: radius of the orifice in the conduit.
    pub orifice_radius: Length,
    /// Safety closure: begin and end of the orifice, along z.
    pub orifice: [Length; 2],
    /// Safety closure: opening of the conduit, along z.
    pub second_outlet: Length,
    /// Slope of the seat's cone from the horizontal.
    pub cone_slope: Angle,
    /// Inner radius of the rubber ring, and outer radius of the cone.
    pub rubber_inner_radius: Length,
    /// Outer radius of the rubber ring and of the disc above it.
    pub rubber_outer_radius: Length,
    /// Height of the undeformed rubber ring.
    pub rubber_height: Length,
    /// Lip: height by which the undeformed ring protrudes below the metal.
    pub lip: Length,
    /// Radius of the chamber above the seat.
    pub chamber_radius: Length,
    /// Height of the chamber, at which the fluid leaves.
    pub chamber_height: Length,
    /// Mass of steel and rubber that move.
    pub moving_mass: Mass,
    /// Density of the steel.
    pub steel: Density,
    /// Density of the rubber.
    pub rubber: Density,
}

/// Closure of the conduit at its far end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Closure {
    /// A wall: all that enters must leave through the valve.
    Pressure,
    /// An orifice and a second outlet.
    Safety,
}

impl Closure {
    /// Pressure above the valve in the runs of Mutabaruka and Kamrin [Pa]. At a safety valve both
    /// outlets lead to the same pressure.
    pub fn outlet(self) -> Pressure {
        Pressure(match self {
            Self::Pressure => 10416.0,
            Self::Safety => 0.0,
        })
    }

    /// Velocity of the piston in those of their runs that vary something else [m/s].
    pub fn piston(self) -> Velocity {
        Velocity(match self {
            Self::Pressure => 6.0,
            Self::Safety => 12.5,
        })
    }
}

impl Default for Dimensions {
    fn default() -> Self {
        let mm = |x: f64| Length(1e-3 * x);
        Self {
            bore_radius: mm(4.75),
            conduit_axis: mm(-9.0),
            inlet: mm(-15.6),
            blind_end: mm(4.75),
            closure: Closure::Pressure,
            orifice_radius: mm(2.0),
            orifice: [mm(7.0), mm(9.0)],
            second_outlet: mm(15.6),
            cone_slope: Angle(29.53 * PI / 180.0),
            rubber_inner_radius: mm(6.5),
            rubber_outer_radius: mm(11.0),
            rubber_height: mm(3.0),
            lip: mm(0.48),
            chamber_radius: mm(15.0),
            chamber_height: mm(15.0),
            moving_mass: Mass(9.2e-3),
            steel: Density(7850.0),
            rubber: Density(1200.0),
        }
    }
}

/// A dimension that does not go with the others.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{key} is {found}, but {rule}")]
pub struct Misfit {
    /// The key.
    pub key: &'static str,
    /// Its value.
    pub found: String,
    /// Rule that it breaks.
    pub rule: String,
}

impl Dimensions {
    /// Depth of the cone [m]: from the flat of the seat down to the bore.
    pub fn cone_depth(&self) -> f64 {
        let slope = libm::sin(self.cone_slope.0) / libm::cos(self.cone_slope.0);
        (self.rubber_inner_radius.0 - self.bore_radius.0) * slope
    }

    /// Height of the hub above the metal's datum [m]: as high as the rubber reaches.
    pub fn hub_height(&self) -> f64 {
        self.rubber_height.0 - self.lip.0
    }

    /// Volume of the plug, the part of the valve in the cone [m³].
    pub fn plug_volume(&self) -> f64 {
        let (a, b) = (self.bore_radius.0, self.rubber_inner_radius.0);
        PI * self.cone_depth() / 3.0 * (a * a + a * b + b * b)
    }

    /// Volume of the hub inside the rubber ring [m³].
    pub fn hub_volume(&self) -> f64 {
        PI * self.rubber_inner_radius.0 * self.rubber_inner_radius.0 * self.hub_height()
    }

    /// Volume of the rubber ring [m³].
    pub fn rubber_volume(&self) -> f64 {
        let (a, b) = (self.rubber_inner_radius.0, self.rubber_outer_radius.0);
        PI * (b * b - a * a) * self.rubber_height.0
    }

    /// Thickness of the steel disc above the rubber [m]: the moving mass, less plug, hub and
    /// rubber, sets it.
    pub fn disc_thickness(&self) -> f64 {
        let steel = (self.moving_mass.0 - self.rubber.0 * self.rubber_volume()) / self.steel.0;
        let disc = steel - self.plug_volume() - self.hub_volume();
        disc / (PI * self.rubber_outer_radius.0 * self.rubber_outer_radius.0)
    }

    /// Everything that does not fit together.
    pub fn misfits(&self) -> Vec<Misfit> {
        let mut misfits = Misfits::default();
        self.check_lengths(&mut misfits);
        self.check_seat(&mut misfits);
        self.check_conduit(&mut misfits);
        misfits.rule(self.disc_thickness() > 0.0, "moving_mass", self.moving_mass, || {
            "must leave something for the disc: plug, hub and rubber alone are heavier".into()
        });
        misfits.found
    }

    fn check_lengths(&self, misfits: &mut Misfits) {
        for (key, length) in [
            ("bore_radius", self.bore_radius),
            ("rubber_height", self.rubber_height),
            ("chamber_height", self.chamber_height),
            ("orifice_radius", self.orifice_radius),
        ] {
            misfits.rule(length.0 > 0.0, key, length, || "must be more than zero".into());
        }
        let right_angle = 0.5 * PI;
        let is_cone = self.cone_slope.0 > 0.0 && self.cone_slope.0 < right_angle;
        misfits.rule(is_cone, "cone_slope", self.cone_slope, || {
            "must be between 0 and 90 degrees".into()
        });
    }

    /// Radii from the bore outwards, and the lip.
    fn check_seat(&self, misfits: &mut Misfits) {
        let (bore, inner, outer) =
            (self.bore_radius, self.rubber_inner_radius, self.rubber_outer_radius);
        misfits.rule(inner > bore, "rubber_inner_radius", inner, || {
            format!("must be more than bore_radius, {bore}: the cone lies between them")
        });
        misfits.rule(outer > inner, "rubber_outer_radius", outer, || {
            format!("must be more than rubber_inner_radius, {inner}")
        });
        misfits.rule(self.chamber_radius > outer, "chamber_radius", self.chamber_radius, || {
            format!("must be more than rubber_outer_radius, {outer}: the fluid passes between")
        });
        let protrudes = self.lip.0 >= 0.0 && self.lip < self.rubber_height;
        misfits.rule(protrudes, "lip", self.lip, || {
            format!("must be between zero and rubber_height, {}", self.rubber_height)
        });
    }

    fn check_conduit(&self, misfits: &mut Misfits) {
        // The conduit's highest line: the bore must be long enough to part from the cone.
        let crown = self.conduit_axis.0 + self.bore_radius.0;
        misfits.rule(crown < -self.cone_depth(), "conduit_axis", self.conduit_axis, || {
            format!("must leave the conduit below the cone, which ends at {} m", -self.cone_depth())
        });
        let chamber = self.chamber_radius;
        misfits.rule(self.inlet.0 < -chamber.0, "inlet", self.inlet, || {
            format!("must be below -chamber_radius, -{chamber}: else the chamber opens there too")
        });
        let bore = self.bore_radius;
        match self.closure {
            Closure::Pressure => {
                misfits.rule(self.blind_end >= bore, "blind_end", self.blind_end, || {
                    format!("must be at least bore_radius, {bore}: the bore ends there")
                });
            }
            Closure::Safety => self.check_orifice(misfits),
        }
    }

    fn check_orifice(&self, misfits: &mut Misfits) {
        let (bore, second) = (self.bore_radius, self.second_outlet);
        misfits.rule(self.orifice_radius < bore, "orifice_radius", self.orifice_radius, || {
            format!("must be less than bore_radius, {bore}")
        });
        let [from, to] = self.orifice;
        let lies = from >= bore && to > from && second > to;
        misfits.rule(lies, "orifice", format_args!("[{from}, {to}]"), || {
            format!(
                "must begin at bore_radius, {bore}, or later, and end before second_outlet, {second}"
            )
        });
        let chamber = self.chamber_radius;
        misfits.rule(second > chamber, "second_outlet", second, || {
            format!("must be more than chamber_radius, {chamber}: else the chamber opens there too")
        });
    }
}

/// The misfits found so far.
#[derive(Default)]
struct Misfits {
    found: Vec<Misfit>,
}

impl Misfits {
    /// Notes a dimension for which a rule does not hold.
    fn rule(
        &mut self,
        holds: bool,
        key: &'static str,
        found: impl std::fmt::Display,
        rule: impl FnOnce() -> String,
    ) {
        if !holds {
            self.found.push(Misfit { key, found: found.to_string(), rule: rule() });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Volumes by hand from the stated radii, the thickness that the moving mass leaves.
    #[test]
    fn the_stated_numbers_give_the_known_volumes() {
        let valve = Dimensions::default();
        let near = |found: f64, expected: f64| (found / expected - 1.0).abs() < 1e-3;
        assert!(near(valve.cone_depth(), 0.991e-3));
        assert!(near(valve.rubber_volume(), 742.2e-9));
        assert!(near(valve.plug_volume(), 99.3e-9));
        assert!(near(valve.hub_volume(), 334.5e-9));
        assert!(near(valve.disc_thickness(), 1.643e-3), "{}", valve.disc_thickness());
        assert_eq!(valve.misfits(), []);
    }

    #[test]
    fn what_does_not_fit_is_named() {
        let keys = |change: fn(&mut Dimensions)| {
            let mut valve = Dimensions::default();
            change(&mut valve);
            valve.misfits().iter().map(|misfit| misfit.key).collect::<Vec<_>>()
        };
        assert_eq!(keys(|v| v.rubber_inner_radius = Length(4e-3)), ["rubber_inner_radius"]);
        assert_eq!(keys(|v| v.conduit_axis = Length(-5e-3)), ["conduit_axis"]);
        assert_eq!(keys(|v| v.moving_mass = Mass(4e-3)), ["moving_mass"]);
        assert_eq!(keys(|v| v.inlet = Length(-14e-3)), ["inlet"]);
        let safety = |v: &mut Dimensions| {
            v.closure = Closure::Safety;
            v.orifice = [Length(7e-3), Length(6e-3)];
        };
        assert_eq!(keys(safety), ["orifice"]);
    }
}
