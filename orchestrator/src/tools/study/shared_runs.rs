//! Runs that several studies have: one study makes each, the others get a copy of its folder.

use super::folder::FolderUse;
use super::{Study, StudyError};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Place of a run among those of several studies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct RunPlace {
    /// Its study, counted from 0.
    pub study: usize,
    /// Its number in the study, counted from 0.
    pub run: usize,
}

impl RunPlace {
    /// Places of all runs, study by study.
    pub fn all(studies: &[Study]) -> impl Iterator<Item = Self> + '_ {
        let of_study =
            |(study, of): (usize, &Study)| (0..of.runs.len()).map(move |run| Self { study, run });
        studies.iter().enumerate().flat_map(of_study)
    }
}

/// Runs that several studies have.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct SharedRuns {
    /// Places that get a copy, by the place where the run is made.
    copies: BTreeMap<RunPlace, Vec<RunPlace>>,
    /// All places that get a copy.
    are_copies: BTreeSet<RunPlace>,
}

impl SharedRuns {
    /// The runs that several of the studies have, of which a cluster has those at `under_way`.
    ///
    /// # Errors
    /// If the disk refuses.
    pub fn of(studies: &[Study], under_way: &BTreeSet<RunPlace>) -> Result<Self, StudyError> {
        let folder = |study: &Study| {
            let folder = study.contents.base.parent().unwrap_or(Path::new(""));
            folder.canonicalize().unwrap_or_else(|_| folder.into())
        };
        let folders: Vec<PathBuf> = studies.iter().map(folder).collect();
        let mut places: BTreeMap<_, Vec<RunPlace>> = BTreeMap::new();
        for place in RunPlace::all(studies) {
            // Runs of the same name have the same resolved manifest and the same files, but for programs and
            // others that are found from the manifest's folder.
            let run = &studies[place.study].runs[place.run];
            // One that fails for want of time must not fail for all.
            let key = (&folders[place.study], &run.name, &run.times);
            places.entry(key).or_default().push(place);
        }
        let mut shared = Self::default();
        for places in places.into_values().filter(|places| places.len() > 1) {
            let use_of = |place: &RunPlace| match under_way.contains(place) {
                true => Ok(FolderUse::UnderWay),
                false => {
                    let study = &studies[place.study];
                    study.folder.use_of(&study.runs[place.run])
                }
            };
            shared.add(&places, &places.iter().map(use_of).collect::<Result<Vec<_>, _>>()?);
        }
        Ok(shared)
    }

    /// Adds a run that is at several places, with the readiness of its folder at each.
    fn add(&mut self, places: &[RunPlace], uses: &[FolderUse]) {
        let order = |found: &FolderUse| match found {
            FolderUse::Done => 0,
            FolderUse::UnderWay => 1,
            FolderUse::BrokenOff => 2,
            FolderUse::Unfinished | FolderUse::Free => 3,
        };
        // Of equal ones the first.
        let made_at = places.iter().zip(uses).min_by_key(|(_, found)| order(found));
        let Some((&made_at, _)) = made_at else { return };
        let others: Vec<_> = places.iter().copied().filter(|place| *place != made_at).collect();
        self.are_copies.extend(&others);
        self.copies.insert(made_at, others);
    }

    /// Places where runs are made that other places get copies of.
    pub fn made_at(&self) -> impl Iterator<Item = RunPlace> + '_ {
        self.copies.keys().copied()
    }

    /// Places that get a copy of the run at `made_at`.
    pub fn copies_of(&self, made_at: RunPlace) -> &[RunPlace] {
        self.copies.get(&made_at).map_or(&[], Vec::as_slice)
    }

    /// True if a place gets a copy.
    pub fn is_copy(&self, place: RunPlace) -> bool {
        self.are_copies.contains(&place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shared_run_is_made_where_it_is_nearest_to_its_end() {
        let places = [0, 1, 2].map(|study| RunPlace { study, run: 4 });
        for (uses, made) in [
            ([FolderUse::Free, FolderUse::Free, FolderUse::Unfinished], 0),
            ([FolderUse::Free, FolderUse::BrokenOff, FolderUse::BrokenOff], 1),
            ([FolderUse::BrokenOff, FolderUse::Free, FolderUse::UnderWay], 2),
            ([FolderUse::UnderWay, FolderUse::Done, FolderUse::Done], 1),
        ] {
            let mut shared = SharedRuns::default();
            shared.add(&places, &uses);
            assert_eq!(shared.made_at().collect::<Vec<_>>(), [places[made]], "{uses:?}");
            let others: Vec<_> = (0..3).filter(|study| *study != made).collect();
            let copies = shared.copies_of(places[made]);
            assert_eq!(copies.iter().map(|it| it.study).collect::<Vec<_>>(), others, "{uses:?}");
            assert!(!shared.is_copy(places[made]) && copies.iter().all(|it| shared.is_copy(*it)));
        }
    }
}
