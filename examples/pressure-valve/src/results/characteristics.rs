//! Moments, means and curves of a valve in a run.
//!
//! A valve is a part that slides on an axis. With `drop` the pressure upstream less that downstream
//! and `Q` the rate of flow through the whole valve:
//!
//! * it *cracks* when its lift first exceeds a given one, and *reseats* when it last falls below it
//!   again;
//! * it is *held* in the middle half of the time in which it is open at least half as far as at
//!   most, and *shut* in the last tenth of what the run simulates, after it has reseated;
//! * its flow coefficient is `Kv = Q sqrt((rho/1000 kg/m³) (1 bar/drop))`, `Q` in m³/h (IEC
//!   60534-1);
//! * grains stuck in a ring probe are counted by their projected area over the ring's (NASP), and
//!   by the debris that they leave, see [`super::debris`].

use super::debris::debris;
use super::valve_signals::Watched;
use serde::Serialize;
use std::collections::BTreeMap;
use tremie_results::Signals;

/// Data of the scene that a run's table of signals lacks.
#[derive(Clone, Debug, PartialEq)]
pub struct Site {
    /// Number of copies of the model that make the whole valve: 2 for half of one.
    pub copies: f64,
    /// Density of the fluid [kg/m³].
    pub density: f64,
    /// Lift above which it counts as open [m].
    pub open_at: Option<f64>,
    /// Area of each ring probe [m²].
    pub rings: BTreeMap<String, f64>,
    /// Mean of the smallest and the largest diameter of the grains [m].
    pub diameter: Option<f64>,
}

/// Characteristics of a valve in a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Characteristics {
    /// Lift above which it counts as open [m].
    pub open_at: f64,
    /// Cracking: its first opening.
    pub cracking: Option<Moment>,
    /// The moment of its greatest lift.
    pub greatest: Moment,
    /// Reseating: its last closing; `None` if it is open at the end.
    pub reseating: Option<Moment>,
    /// Means while it was held open.
    pub held: Option<Stretch>,
    /// Means while it was shut, at the end.
    pub shut: Option<Stretch>,
    /// Greatest pressure of each seal on its seat: signal, time [s], pressure [Pa].
    pub seals: Vec<(String, f64, f64)>,
    /// Grains stuck at the end, by probe.
    pub stuck: Vec<Stuck>,
}

/// The valve at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Moment {
    /// Time [s].
    pub time: f64,
    /// Lift [m].
    pub lift: f64,
    /// Pressure drop [Pa].
    pub drop: f64,
}

/// Means over some time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stretch {
    /// It begins and ends [s].
    pub from: f64,
    /// See `from`.
    pub until: f64,
    /// Lift: mean, least, greatest [m].
    pub lift: [f64; 3],
    /// Pressure drop [Pa].
    pub drop: f64,
    /// Rate of flow through the whole valve [m³/s].
    pub flow: Option<f64>,
    /// Flow coefficient [m³/h at 1 bar].
    pub kv: Option<f64>,
    /// Forces on the valve along its axis, by signal [N].
    pub forces: BTreeMap<String, f64>,
}

/// Grains in a ring.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stuck {
    /// The probe.
    pub probe: String,
    /// Their projected area over the ring's.
    pub area_fraction: f64,
    /// Debris, in cubes of a grain's diameter.
    pub debris: Option<f64>,
}

/// Characteristics of a valve, whose names among a run's signals are `watched`.
///
/// # Errors
/// A sentence, if the run is too short.
pub fn characteristics(
    signals: &Signals,
    watched: &Watched,
    site: &Site,
) -> Result<Characteristics, String> {
    let run = Run::of(signals, watched)?;
    let last = run.times.len().checked_sub(1).ok_or("the run has no signals")?;
    let peak = (0..=last).fold(0, |best, k| if run.lift[k] > run.lift[best] { k } else { best });
    // A tenth of its way, unless the user gives a lift.
    let open_at = site.open_at.unwrap_or(run.lift[0] + 0.1 * (run.lift[peak] - run.lift[0]));
    let is_open = |k: usize| run.lift[k] > open_at;
    let cracked = (1..=last).find(|&k| is_open(k) && !is_open(k - 1));
    // Only a valve that has opened can reseat, and only one that is shut at the end has.
    let reseated = cracked
        .and((1..=last).rfind(|&k| !is_open(k) && is_open(k - 1)))
        .filter(|_| !is_open(last));
    let half = 0.5 * (run.lift[0] + run.lift[peak]);
    let is_far = |k: &usize| is_open(*k) && run.lift[*k] >= half;
    let far =
        if is_open(peak) { (0..=last).find(is_far).zip((0..=last).rfind(is_far)) } else { None };
    let held = far.and_then(|(first, last)| {
        let (from, until) = (run.times[first], run.times[last]);
        // The middle half: the ends still hold the opening and the closing.
        let quarter = 0.25 * (until - from);
        run.stretch(from + quarter, until - quarter, site)
    });
    let shut = reseated.map(|from| {
        let until = run.times[last];
        run.stretch(until - (0.1 * until).min(until - run.times[from]), until, site)
    });
    Ok(Characteristics {
        open_at,
        cracking: cracked.map(|k| run.moment(k)),
        greatest: run.moment(peak),
        reseating: reseated.map(|k| run.moment(k)),
        held,
        shut: shut.flatten(),
        seals: seals(signals),
        stuck: all_stuck(signals, site, run.lift[last]),
    })
}

/// The curves of pressure drop over rate of flow, of rate of flow over lift, and of flow
/// coefficient over lift, in the order of time. Each point is a mean over one of `parts` of the
/// run, so that sound averages out; only the open valve counts.
///
/// # Errors
/// A sentence, if a signal is missing.
pub fn curves(
    signals: &Signals,
    watched: &Watched,
    site: &Site,
    open_at: f64,
    parts: usize,
) -> Result<[Vec<(f64, f64)>; 3], String> {
    let run = Run::of(signals, watched)?;
    let mut curves = [const { Vec::new() }; 3];
    let all: Vec<usize> = (0..run.times.len()).collect();
    for part in all.chunks(all.len().div_ceil(parts).max(1)) {
        let lift = mean(part, run.lift);
        let Some(flow) = run.flow.map(|flow| site.copies * mean(part, flow)) else { continue };
        let drop = mean(part, &run.drop);
        if lift > open_at && flow.is_finite() && drop.is_finite() {
            curves[0].push((flow, drop));
            curves[1].push((lift, flow));
            curves[2].extend(kv(flow, drop, site.density).map(|kv| (lift, kv)));
        }
    }
    Ok(curves)
}

/// Mean of some rows, without those that were not measured.
fn mean(rows: &[usize], of: &[f64]) -> f64 {
    let measured = || rows.iter().map(|&k| of[k]).filter(|value| value.is_finite());
    measured().sum::<f64>() / measured().count() as f64
}

/// Flow coefficient [m³/h at 1 bar] of a rate of flow [m³/s] under a pressure drop [Pa], if both go
/// downstream.
fn kv(flow: f64, drop: f64, density: f64) -> Option<f64> {
    (flow > 0.0 && drop > 0.0).then(|| 3600.0 * flow * (density / 1000.0 * 1e5 / drop).sqrt())
}

/// The columns of a run.
struct Run<'a> {
    times: &'a [f64],
    lift: &'a [f64],
    drop: Vec<f64>,
    flow: Option<&'a [f64]>,
    forces: Vec<(&'a String, &'a [f64])>,
}

impl<'a> Run<'a> {
    fn of(signals: &'a Signals, watched: &'a Watched) -> Result<Self, String> {
        let column = |name: &String| signals.column(name);
        let mut drop = column(&watched.upstream)?.to_vec();
        if let Some(downstream) = &watched.downstream {
            drop.iter_mut().zip(column(downstream)?).for_each(|(drop, below)| *drop -= below);
        }
        let flow = watched.flow.as_ref().map(column).transpose()?;
        let forces = watched.forces.iter().map(|name| Ok((name, column(name)?)));
        Ok(Self {
            times: &signals.times,
            lift: column(&watched.lift)?,
            drop,
            flow,
            forces: forces.collect::<Result<_, String>>()?,
        })
    }

    fn moment(&self, k: usize) -> Moment {
        Moment { time: self.times[k], lift: self.lift[k], drop: self.drop[k] }
    }

    fn stretch(&self, from: f64, until: f64, site: &Site) -> Option<Stretch> {
        let within: Vec<usize> =
            (0..self.times.len()).filter(|&k| (from..=until).contains(&self.times[k])).collect();
        let mean = |of: &[f64]| mean(&within, of);
        let extreme =
            |better: fn(f64, f64) -> f64| within.iter().map(|&k| self.lift[k]).reduce(better);
        let drop = mean(&self.drop);
        let flow = self.flow.map(|flow| site.copies * mean(flow)).filter(|flow| flow.is_finite());
        Some(Stretch {
            from,
            until,
            lift: [mean(self.lift), extreme(f64::min)?, extreme(f64::max)?],
            drop,
            flow,
            kv: flow.and_then(|flow| kv(flow, drop, site.density)),
            forces: self.forces.iter().map(|(name, of)| ((*name).clone(), mean(of))).collect(),
        })
    }
}

/// Greatest pressures of seals on their seats.
fn seals(signals: &Signals) -> Vec<(String, f64, f64)> {
    let of_seals = signals.columns.iter().filter(|(name, _)| name.ends_with(".peak_seat_pressure"));
    let greatest = of_seals.filter_map(|(name, values)| {
        let with_times = signals.times.iter().zip(values).filter(|(_, value)| value.is_finite());
        let (time, value) = with_times.reduce(|a, b| if b.1 > a.1 { b } else { a })?;
        Some((name.clone(), *time, *value))
    });
    greatest.filter(|(_, _, value)| *value > 0.0).collect()
}

/// Grains stuck at the end in each ring probe, the valve at a lift [m].
fn all_stuck(signals: &Signals, site: &Site, lift: f64) -> Vec<Stuck> {
    let of_ring = |(probe, area): (&String, &f64)| {
        let values = signals.columns.get(&format!("grains.{probe}.area_fraction"))?;
        let area_fraction = *values.iter().rfind(|value| value.is_finite())?;
        let debris = site.diameter.map(|d| debris(lift, *area, area_fraction, d));
        Some(Stuck { probe: probe.clone(), area_fraction, debris })
    };
    // Without grains a ring probe is there for the fluid.
    let rings = site.diameter.iter().flat_map(|_| &site.rings);
    rings.filter_map(of_ring).collect()
}

#[cfg(test)]
mod tests {
    use super::super::valve_signals::Asked;
    use super::*;

    /// Shut until 1 s, open by 2 mm until 3 s, then shut; 1 L/s in half of it under 4 bar while it
    /// is open.
    fn run() -> Signals {
        let times: Vec<f64> = (0..=400).map(|k| f64::from(k) * 0.01).collect();
        let of = |open: f64, shut: f64| {
            times.iter().map(|t| if *t > 1.0 && *t < 3.0 { open } else { shut }).collect::<Vec<_>>()
        };
        let columns = [
            ("fluid.inlet.pressure", of(4.1e5, 2.1e5)),
            ("fluid.above.pressure", of(1e4, 1e4)),
            ("fluid.outflow.flow_rate", of(1e-3, -1e-6)),
            ("grains.valve.lift", of(2e-3, 1e-4)),
            ("grains.valve.spring_force", of(-60.0, -50.0)),
            ("grains.stuck.area_fraction", of(0.3, 0.2)),
            ("rubber.ring.peak_seat_pressure", of(0.0, 7e5)),
        ];
        let columns = columns.map(|(name, values)| (name.to_string(), values)).into();
        Signals { times, columns, ..Signals::default() }
    }

    fn site() -> Site {
        let rings = [("stuck".to_string(), 3e-4)].into();
        Site { copies: 2.0, density: 1000.0, open_at: None, rings, diameter: Some(1e-3) }
    }

    fn found() -> Characteristics {
        let asked = Asked {
            upstream: Some("inlet".into()),
            downstream: Some("above".into()),
            ..Asked::default()
        };
        let signals = run();
        let watched = Watched::find(&signals, &asked).unwrap();
        characteristics(&signals, &watched, &site()).unwrap()
    }

    #[test]
    fn a_stroke_is_read() {
        let found = found();
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-9;
        let (cracking, reseating) = (found.cracking.unwrap(), found.reseating.unwrap());
        assert!(near(cracking.time, 1.01) && near(cracking.drop, 4e5) && near(reseating.time, 3.0));
        let held = found.held.unwrap();
        assert!(
            near(held.drop, 4e5)
                && near(held.flow.unwrap(), 2e-3)
                && held.from > 1.4
                && held.until < 2.6
        );
        // 7.2 m³/h at 4 bar are 3.6 at one.
        assert!(near(held.kv.unwrap(), 3.6));
        assert!(near(held.forces["grains.valve.spring_force"], -60.0));
        let shut = found.shut.unwrap();
        assert!(near(shut.flow.unwrap(), -2e-6) && shut.kv.is_none() && near(shut.from, 3.6));
        assert_eq!(found.seals, [("rubber.ring.peak_seat_pressure".to_string(), 0.0, 7e5)]);
        // 1e-4 m x 3e-4 m² x 0.2 in cubes of a millimetre.
        assert!(
            near(found.stuck[0].area_fraction, 0.2) && near(found.stuck[0].debris.unwrap(), 6.0)
        );
    }

    #[test]
    fn what_stays_shut_has_no_moments() {
        let mut signals = run();
        signals.columns.insert("grains.valve.lift".into(), vec![1e-4; 401]);
        let watched =
            Watched::find(&signals, &Asked { upstream: Some("inlet".into()), ..Asked::default() })
                .unwrap();
        let found = characteristics(&signals, &watched, &site()).unwrap();
        assert!(found.cracking.is_none() && found.held.is_none() && found.shut.is_none());
        let open = Site { open_at: Some(0.0), ..site() };
        let found = characteristics(&signals, &watched, &open).unwrap();
        assert!(found.cracking.is_none() && found.reseating.is_none(), "open throughout");
    }

    #[test]
    fn curves_are_those_of_the_open_valve() {
        let signals = run();
        let watched =
            Watched::find(&signals, &Asked { upstream: Some("inlet".into()), ..Asked::default() })
                .unwrap();
        let [drop, flow, kv] = curves(&signals, &watched, &site(), 1e-3, 401).unwrap();
        assert_eq!((drop.len(), flow.len(), kv.len()), (199, 199, 199));
        assert_eq!(drop[7], (2e-3, 4.1e5));
        assert_eq!(flow[7], (2e-3, 2e-3));
    }
}
