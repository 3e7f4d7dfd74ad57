//! Tables of a profile of grains, read again from the file of the run.

use crate::signals::name_and_unit;
use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

/// Folder of the profiles of a run.
pub const PROFILES: &str = "profiles";

/// All tables of a profile.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProfileTables {
    /// Its name.
    pub name: String,
    /// The binned axes, one or two: name, and the middle of each bin [m].
    pub axes: Vec<(String, Vec<f64>)>,
    /// Simulated time of the begin and the end of each table [s].
    pub times: Vec<[f64; 2]>,
    /// Values of all bins of all tables by the name of the column: table after table, the second
    /// axis fastest.
    pub columns: BTreeMap<String, Vec<f64>>,
}

/// A table of a profile could not be read.
#[derive(Debug, thiserror::Error)]
#[error("{}: {message}", path.display())]
pub struct UnreadableProfile {
    /// The file.
    pub path: PathBuf,
    /// A sentence.
    pub message: String,
}

/// The profiles of a run in the folder `out`, by name; none where it has none.
///
/// # Errors
/// Files that are no tables of a profile.
pub fn profiles_of(out: &Path) -> Result<Vec<ProfileTables>, UnreadableProfile> {
    let Ok(entries) = std::fs::read_dir(out.join(PROFILES)) else { return Ok(Vec::new()) };
    let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let is_table = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "csv");
    let mut paths: Vec<PathBuf> = paths.filter(is_table).collect();
    paths.sort();
    paths.iter().map(|path| ProfileTables::read(path)).collect()
}

impl ProfileTables {
    /// Reads the tables of a file; one that was cut off is left out.
    ///
    /// # Errors
    /// A file that is no table of a profile.
    pub fn read(path: &Path) -> Result<Self, UnreadableProfile> {
        let unreadable = |message| UnreadableProfile { path: path.to_path_buf(), message };
        let file = File::open(path).map_err(|error| unreadable(error.to_string()))?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Self::parse(name, file).map_err(unreadable)
    }

    fn parse(name: String, text: impl std::io::Read) -> Result<Self, String> {
        let mut reader = csv::ReaderBuilder::new().flexible(true).from_reader(text);
        let heads = reader.headers().map_err(|error| error.to_string())?;
        let names: Vec<String> = heads.iter().map(|head| name_and_unit(head).0).collect();
        let is_axis = |name: &&String| ["x", "y", "z"].contains(&name.as_str());
        let axes = names.iter().skip(FIXED.len()).take_while(is_axis).count();
        if !names.iter().map(String::as_str).take(FIXED.len()).eq(FIXED) || !(1..=2).contains(&axes)
        {
            return Err(format!(
                "it is no table of a profile: its first line does not begin with {} and one axis or two",
                FIXED.join(", ")
            ));
        }
        let mut columns = vec![Vec::new(); names.len()];
        for record in reader.records() {
            let Ok(record) = record else { break };
            let values: Vec<f64> = record.iter().filter_map(|text| text.parse().ok()).collect();
            if values.len() != names.len() {
                // The end of a file whose run was killed.
                break;
            }
            columns.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
        }
        let begins = &columns[0];
        let bins = begins.iter().take_while(|begin| **begin == begins[0]).count();
        let whole = begins.len().checked_div(bins).unwrap_or(0) * bins;
        columns.iter_mut().for_each(|column| column.truncate(whole));
        let first = FIXED.len();
        // The last axis is the fastest.
        let inner = columns[first].iter().take(bins).take_while(|x| **x == columns[first][0]);
        let inner = inner.count().max(1);
        let steps = if axes == 1 { vec![(1, bins)] } else { vec![(inner, bins), (1, inner)] };
        let middles = |(k, (step, end)): (usize, (usize, usize))| {
            let column = &columns[first + k];
            let of_bins = column.iter().take(end).step_by(step);
            (names[first + k].clone(), of_bins.copied().collect())
        };
        let axes: Vec<_> = steps.into_iter().enumerate().map(middles).collect();
        let times = (0..whole).step_by(bins.max(1));
        let times = times.map(|row| [columns[0][row], columns[1][row]]).collect();
        Ok(Self { name, axes, times, columns: names.into_iter().zip(columns).collect() })
    }

    /// Number of bins.
    pub fn bins(&self) -> usize {
        self.axes.iter().map(|(_, middles)| middles.len()).product()
    }

    /// Values of a column in a table, bin by bin; empty where there is none.
    pub fn of_table(&self, column: &str, table: usize) -> &[f64] {
        let values = self.columns.get(column).map_or(&[][..], Vec::as_slice);
        values.chunks(self.bins().max(1)).nth(table).unwrap_or_default()
    }
}

/// Names of the first columns.
const FIXED: [&str; 3] = ["begin", "end", "samples"];

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "begin [s],end [s],samples [1],x [m],z [m],solid_fraction [1]\n\
        0,1,5,0.5,0.1,1\n0,1,5,0.5,0.2,2\n0,1,5,0.5,0.3,3\n0,1,5,1.5,0.1,4\n0,1,5,1.5,0.2,5\n0,1,5,1.5,0.3,NaN\n\
        1,2,5,0.5,0.1,7\n1,2,5,0.5,0.2,8\n1,2,5,0.5,0.3,9\n1,2,5,1.5,0.1,10\n1,2,5,1.5,0.2,11\n1,2,5,1.5,0.3,12\n\
        2,3,5,0.5,0.1,13\n2,3,5,0.5,0.";

    fn parse(text: &str) -> Result<ProfileTables, String> {
        ProfileTables::parse("p".into(), text.as_bytes())
    }

    #[test]
    fn tables_are_read_and_one_that_was_cut_off_is_left_out() {
        let tables = parse(TABLE).unwrap();
        assert_eq!(tables.axes[0], ("x".to_string(), vec![0.5, 1.5]));
        assert_eq!(tables.axes[1], ("z".to_string(), vec![0.1, 0.2, 0.3]));
        assert_eq!(tables.times, [[0.0, 1.0], [1.0, 2.0]]);
        assert_eq!(tables.of_table("solid_fraction", 1), [7.0, 8.0, 9.0, 10.0, 11.0, 12.0]);
        assert!(tables.of_table("solid_fraction", 0)[5].is_nan());
        assert!(tables.of_table("speed", 0).is_empty());
        let one = parse("begin [s],end [s],samples [1],y [m],a [1]\n0,1,5,0.5,1\n0,1,5,1.5,2\n");
        let one = one.unwrap();
        assert_eq!((one.bins(), one.of_table("a", 0)), (2, &[1.0, 2.0][..]));
        let none = parse("begin [s],end [s],samples [1],y [m],a [1]\n").unwrap();
        assert_eq!((none.bins(), none.times.len()), (0, 0));
    }

    #[test]
    fn other_tables_are_refused() {
        let error = parse("window,time [s],a [m]\n0,0,1\n").unwrap_err();
        assert!(error.contains("no table of a profile"), "{error}");
    }
}
