//! `runs.parquet`: the table of results with the types of its columns, for pandas, Polars, DuckDB.

use super::axes::value_text;
use super::columns::StudyColumn;
use super::contents::StudyContents;
use super::runs::StudyRun;
use super::table::RunResults;
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{Type, TypePtr};
use serde_json::Value;
use std::sync::Arc;

/// A column: a name, and a cell for each row, or none.
struct TypedColumn {
    name: String,
    cells: TypedCells,
}

enum TypedCells {
    Whole(Vec<Option<i64>>),
    Real(Vec<Option<f64>>),
    Text(Vec<Option<String>>),
}

/// The file, with the columns and rows of `runs.csv`. A key whose values are all plain numbers is a
/// column of numbers; one with units is a column of text, as the study file has it.
///
/// # Errors
/// What the format refuses.
pub fn parquet_table(
    contents: &StudyContents,
    columns: &[StudyColumn],
    rows: &[(&StudyRun, &RunResults)],
) -> Result<Vec<u8>, ParquetError> {
    let columns = typed_columns(contents, columns, rows);
    let fields = columns.iter().map(TypedColumn::field).collect::<Result<_, _>>()?;
    let schema = Type::group_type_builder("runs").with_fields(fields).build()?;
    let properties = Arc::new(WriterProperties::default());
    let mut file = SerializedFileWriter::new(Vec::new(), Arc::new(schema), properties)?;
    let mut group = file.next_row_group()?;
    for column in &columns {
        let mut writer = group.next_column()?.ok_or_else(|| ParquetError::EOF("columns".into()))?;
        column.cells.write(&mut writer)?;
        writer.close()?;
    }
    group.close()?;
    file.into_inner()
}

fn typed_columns(
    contents: &StudyContents,
    columns: &[StudyColumn],
    rows: &[(&StudyRun, &RunResults)],
) -> Vec<TypedColumn> {
    let text = |get: fn(&StudyRun, &RunResults) -> String| {
        TypedCells::Text(rows.iter().map(|(run, results)| Some(get(run, results))).collect())
    };
    let points = rows.iter().map(|(run, _)| i64::try_from(run.point).ok()).collect();
    let seeds = rows.iter().map(|(run, _)| run.seed.map(i64::from)).collect();
    let mut typed = vec![
        TypedColumn::new("point", TypedCells::Whole(points)),
        TypedColumn::new("seed", TypedCells::Whole(seeds)),
    ];
    for (k, key) in contents.keys().enumerate() {
        let values: Vec<&Value> = rows.iter().map(|(run, _)| &run.values[k]).collect();
        typed.push(TypedColumn::new(key, values_of_key(&values)));
    }
    typed.push(TypedColumn::new("run", text(|run, _| run.name.clone())));
    typed.push(TypedColumn::new("status", text(|_, results| results.status.clone())));
    for (k, column) in columns.iter().enumerate() {
        // A number that is none is nothing, as in the CSV file.
        let number = |(_, results): &(_, &RunResults)| results.numbers[k].filter(|x| x.is_finite());
        let cells = TypedCells::Real(rows.iter().map(number).collect());
        typed.push(TypedColumn::new(&column.heading(), cells));
    }
    typed
}

fn values_of_key(values: &[&Value]) -> TypedCells {
    if values.iter().all(|value| value.is_number()) {
        return TypedCells::Real(values.iter().map(|value| value.as_f64()).collect());
    }
    TypedCells::Text(values.iter().map(|value| Some(value_text(value))).collect())
}

impl TypedColumn {
    fn new(name: &str, cells: TypedCells) -> Self {
        Self { name: name.into(), cells }
    }

    fn field(&self) -> Result<TypePtr, ParquetError> {
        let (physical, logical) = match self.cells {
            TypedCells::Whole(_) => (Physical::INT64, None),
            TypedCells::Real(_) => (Physical::DOUBLE, None),
            TypedCells::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let field = Type::primitive_type_builder(&self.name, physical);
        let field = field.with_repetition(Repetition::OPTIONAL).with_logical_type(logical);
        field.build().map(Arc::new)
    }
}

impl TypedCells {
    fn write(&self, writer: &mut SerializedColumnWriter<'_>) -> Result<(), ParquetError> {
        match self {
            Self::Whole(cells) => write_cells::<Int64Type, _>(writer, cells, |&cell| cell),
            Self::Real(cells) => write_cells::<DoubleType, _>(writer, cells, |&cell| cell),
            Self::Text(cells) => write_cells::<ByteArrayType, _>(writer, cells, |cell| {
                ByteArray::from(cell.as_str())
            }),
        }
    }
}

/// Writes the cells that are there, and for each row whether its cell is: 1, else 0.
fn write_cells<D: DataType, C>(
    writer: &mut SerializedColumnWriter<'_>,
    cells: &[Option<C>],
    of: impl Fn(&C) -> D::T,
) -> Result<(), ParquetError> {
    let there: Vec<i16> = cells.iter().map(|cell| i16::from(cell.is_some())).collect();
    let values: Vec<D::T> = cells.iter().flatten().map(of).collect();
    writer.typed::<D>().write_batch(&values, Some(&there), None)?;
    Ok(())
}
