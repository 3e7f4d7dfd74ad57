//! Checks of `[scene.contacts]`.

use super::super::document::{ContactTable, ContactsTable};
use super::super::path;
use super::super::read::Findings;
use tremie_messages::scene::{ContactLaw, Damping, Spring};
use tremie_messages::units::Dashpot;

pub(super) fn contacts(table: &ContactsTable, findings: &mut Findings) -> Option<[ContactLaw; 2]> {
    let at = "scene.contacts";
    let body_body = findings.required(&table.body_body, at, "body_body")?;
    let between = law(&body_body, &path::join(at, "body_body"), findings);
    // The law of walls is a copy where the user gave none: its problems are told once.
    let with_wall = match &table.body_wall {
        Some(own) if *own != body_body => law(own, &path::join(at, "body_wall"), findings),
        _ => between.clone(),
    };
    Some([between?, with_wall?])
}

fn law(table: &ContactTable, at: &str, findings: &mut Findings) -> Option<ContactLaw> {
    let normal = findings.positive(&table.normal_stiffness, at, "normal_stiffness");
    let tangential = findings.required(&table.tangential_stiffness, at, "tangential_stiffness");
    let tangential =
        tangential.filter(|k| findings.not_negative(*k, &path::join(at, "tangential_stiffness")));
    let friction =
        table.friction.filter(|mu| findings.not_negative(*mu, &path::join(at, "friction")));
    let damping = damping(table, at, findings);
    Some(ContactLaw {
        spring: Spring::Linear { normal_stiffness: normal?, tangential_stiffness: tangential?.0 },
        friction: friction?,
        rolling_friction: 0.0,
        damping: damping?,
        tension: table.tension?,
    })
}

fn damping(table: &ContactTable, at: &str, findings: &mut Findings) -> Option<Damping> {
    let dashpots = table.normal_damping.is_some() || table.tangential_damping.is_some();
    match table.restitution {
        Some(_) if dashpots => {
            let message = "found dashpots too, expected either restitution or normal_damping and tangential_damping";
            findings.problem(&path::join(at, "restitution"), message);
            None
        }
        Some(e) if e > 0.0 && e <= 1.0 => Some(Damping::Restitution(e)),
        Some(e) => {
            let message = format!("found {e}, expected more than 0 and at most 1");
            findings.problem(&path::join(at, "restitution"), message);
            None
        }
        None if dashpots => coefficients(table, at, findings),
        None => {
            let keys = ["restitution", "normal_damping", "tangential_damping"];
            if !keys.iter().any(|key| findings.is_unreadable(&path::join(at, key))) {
                findings.problem(
                    at,
                    "missing: damping, as restitution, or as normal_damping and tangential_damping",
                );
            }
            None
        }
    }
}

fn coefficients(table: &ContactTable, at: &str, findings: &mut Findings) -> Option<Damping> {
    let mut read = |value: &Option<Dashpot>, key: &str| {
        let value = findings.required(value, at, key)?;
        findings.not_negative(value, &path::join(at, key)).then_some(value.0)
    };
    let normal = read(&table.normal_damping, "normal_damping");
    let tangential = read(&table.tangential_damping, "tangential_damping");
    Some(Damping::Coefficients { normal: normal?, tangential: tangential? })
}
