//! JuPedSim's trajectory database: tables `trajectory_data`, `metadata`, `geometry` and `frame_data`.

use super::rows::{Id, Rows};
use crate::area::WalkableArea;
use crate::sqlite::{Database, Record, Table, Value};
use crate::{Error, Result};

/// Reads the database: people, and the walkable area of the first frame.
pub(super) fn read(bytes: &[u8]) -> Result<(Rows, Option<WalkableArea>)> {
    let database = Database::new(bytes)?;
    let tables = Table::all(&database)?;
    let rate = frame_rate(&database, &tables)?;
    let mut rows = read_people(&database, Table::named(&tables, "trajectory_data")?, rate)?;
    let area = read_area(&database, &tables, &mut rows.remarks)?;
    Ok((rows, area))
}

fn frame_rate(database: &Database<'_>, tables: &[Table]) -> Result<f64> {
    let table = Table::named(tables, "metadata")?;
    let (key, value) = (table.column("key")?, table.column("value")?);
    let mut found = None;
    table.scan(database, &mut |row: &Record<'_>| {
        if row.value(key).as_text() == Some("fps") {
            let value = row.value(value);
            let rate = value.as_f64().or_else(|| value.as_text().and_then(|text| text.trim().parse().ok()));
            let rate = rate.filter(|rate| super::RATES_HZ.contains(rate));
            let expected = format!("frames a second, {:?}", super::RATES_HZ);
            found = Some(rate.ok_or_else(|| Error::content("table metadata, key fps", value, expected))?);
        }
        Ok(())
    })?;
    found.ok_or_else(|| Error::content("table metadata", "no key fps", "frames a second"))
}

fn read_people(database: &Database<'_>, table: &Table, rate: f64) -> Result<Rows> {
    let [frame, id, x, y] =
        [table.column("frame")?, table.column("id")?, table.column("pos_x")?, table.column("pos_y")?];
    let facing = table.find("ori_x").zip(table.find("ori_y"));
    let mut rows = Rows::of_rate(rate);
    let mut number = 0;
    table.scan(database, &mut |row: &Record<'_>| {
        number += 1;
        let refused = |name: &str, value: Value<'_>, expected: &str| {
            Error::content(format!("table trajectory_data, row {number}, column {name}"), value, expected)
        };
        let coordinate = |name: &str, column: usize| {
            let value = row.value(column);
            value.as_f64().filter(|v| v.is_finite()).ok_or_else(|| refused(name, value, "a finite number"))
        };
        let whole = |name: &str, column: usize| {
            row.value(column).as_i64().ok_or_else(|| refused(name, row.value(column), "a whole number"))
        };
        let time_s = whole("frame", frame)? as f64 / rate;
        let place = [coordinate("pos_x", x)?, coordinate("pos_y", y)?];
        let facing = facing.map_or([0.0; 2], |columns| {
            [columns.0, columns.1].map(|column| row.value(column).as_f64().unwrap_or(0.0) as f32)
        });
        rows.push(number, Id::Number(whole("id", id)?), time_s, place, facing)
    })?;
    Ok(rows)
}

/// The area of the first frame; older files have one area and no `frame_data`.
fn read_area(database: &Database<'_>, tables: &[Table], remarks: &mut Vec<String>) -> Result<Option<WalkableArea>> {
    let Ok(table) = Table::named(tables, "geometry") else {
        remarks.push("no table geometry: no walkable area".to_owned());
        return Ok(None);
    };
    let (wkt, hash) = (table.column("wkt")?, table.find("hash"));
    let wanted = match (Table::named(tables, "frame_data"), hash) {
        (Ok(frames), Some(_)) => first_hash(database, frames)?,
        _ => None,
    };
    let (mut count, mut chosen): (usize, Option<WalkableArea>) = (0, None);
    table.scan(database, &mut |row: &Record<'_>| {
        count += 1;
        let is_wanted = match (wanted, hash) {
            (Some(wanted), Some(column)) => row.value(column).as_i64() == Some(wanted),
            _ => count == 1,
        };
        if is_wanted && chosen.is_none() {
            let value = row.value(wkt);
            let text = value.as_text().ok_or_else(|| {
                Error::content(format!("table geometry, row {count}"), value, "the area as well-known text")
            })?;
            chosen = Some(WalkableArea::parse(text)?);
        }
        Ok(())
    })?;
    if count > 1 {
        remarks.push(format!("{count} walkable areas; shown is that of the first frame"));
    }
    Ok(chosen)
}

fn first_hash(database: &Database<'_>, table: &Table) -> Result<Option<i64>> {
    let (frame, hash) = (table.column("frame")?, table.column("geometry_hash")?);
    let mut first: Option<(i64, i64)> = None;
    table.scan(database, &mut |row: &Record<'_>| {
        if let (Some(frame), Some(hash)) = (row.value(frame).as_i64(), row.value(hash).as_i64()) {
            first = Some(first.map_or((frame, hash), |before| before.min((frame, hash))));
        }
        Ok(())
    })?;
    Ok(first.map(|(_, hash)| hash))
}
