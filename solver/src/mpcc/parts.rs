//! Linear programs with pairs that fall apart: parts that share no row and no pair.
//!
//! Ten copies of a program whose certificate takes two branches ask for a thousand branches as a whole, and for twenty as ten. Rows that
//! hold nothing do not tie them together.

use super::linear_program::LinearProgram;

/// A part of a linear program.
pub(crate) struct Part {
    /// Its variables, in ascending order.
    pub(crate) variables: Vec<usize>,
    /// Its pairs, by their places among its variables.
    pub(crate) pairs: Vec<(usize, usize)>,
}

/// Rows that a program does without, by their entries and the room that they leave.
pub(crate) struct LetGo {
    entries: Vec<((usize, usize), f64)>,
    room: Vec<(f64, f64)>,
}

impl LetGo {
    /// The largest part of a direction that the rows leave, 1 at most.
    pub(crate) fn longest(&self, d: &[f64]) -> f64 {
        let mut change = vec![0.0; self.room.len()];
        for &((row, k), a) in &self.entries {
            change[row] += a * d[k];
        }
        let rows = change.iter().zip(&self.room);
        rows.fold(1.0, |longest, (&change, &(below, above))| {
            let room = if change < 0.0 { below } else { above };
            if change.abs() * longest > room.abs() {
                room.abs() / change.abs()
            } else {
                longest
            }
        })
    }
}

/// Drops the bounds of rows that leave at least a part `far` of any direction within the bounds of the variables; returns the rows.
pub(crate) fn let_go(program: &mut LinearProgram, far: f64) -> LetGo {
    let mut reach = vec![0.0; program.row_lower.len()];
    for (&(row, k), a) in program.pattern.iter().zip(&program.values) {
        reach[row] += (a * program.upper[k].max(-program.lower[k])).abs();
    }
    let mut room = vec![(f64::NEG_INFINITY, f64::INFINITY); reach.len()];
    for (row, reach) in reach.iter().enumerate() {
        if program.row_lower[row] < -far * reach {
            room[row].0 = std::mem::replace(&mut program.row_lower[row], f64::NEG_INFINITY);
        }
        if program.row_upper[row] > far * reach {
            room[row].1 = std::mem::replace(&mut program.row_upper[row], f64::INFINITY);
        }
    }
    let entries = program
        .pattern
        .iter()
        .copied()
        .zip(program.values.iter().copied());
    LetGo {
        entries: entries.collect(),
        room,
    }
}

/// Whether a row can hold anything.
fn holds(program: &LinearProgram, row: usize) -> bool {
    program.row_lower[row].is_finite() || program.row_upper[row].is_finite()
}

/// The program of a part.
pub(crate) fn of_part(program: &LinearProgram, part: &Part) -> LinearProgram {
    let mut columns = vec![None; program.gradient.len()];
    for (place, &i) in part.variables.iter().enumerate() {
        columns[i] = Some(place);
    }
    let mut rows = vec![None; program.row_lower.len()];
    let mut own = LinearProgram {
        gradient: Vec::new(),
        pattern: Vec::new(),
        values: Vec::new(),
        row_lower: Vec::new(),
        row_upper: Vec::new(),
        lower: Vec::new(),
        upper: Vec::new(),
    };
    for &i in &part.variables {
        own.gradient.push(program.gradient[i]);
        own.lower.push(program.lower[i]);
        own.upper.push(program.upper[i]);
    }
    for (&(row, column), &value) in program.pattern.iter().zip(&program.values) {
        let Some(column) = columns[column].filter(|_| holds(program, row)) else {
            continue;
        };
        let place = *rows[row].get_or_insert_with(|| {
            own.row_lower.push(program.row_lower[row]);
            own.row_upper.push(program.row_upper[row]);
            own.row_lower.len() - 1
        });
        own.pattern.push((place, column));
        own.values.push(value);
    }
    own
}

/// The parts of a program with these pairs; variables that cannot move are in none.
pub(crate) fn parts(program: &LinearProgram, pairs: &[(usize, usize)]) -> Vec<Part> {
    let n = program.gradient.len();
    let moves = |i: usize| program.lower[i] < program.upper[i];
    let mut parents: Vec<usize> = (0..n).collect();
    let mut first = vec![None; program.row_lower.len()];
    for (&(row, k), value) in program.pattern.iter().zip(&program.values) {
        if *value != 0.0 && moves(k) && holds(program, row) {
            unite(&mut parents, *first[row].get_or_insert(k), k);
        }
    }
    for &(i, j) in pairs {
        unite(&mut parents, i, j);
    }
    let mut of_root = vec![None; n];
    let mut places = vec![0; n];
    let mut all: Vec<Part> = Vec::new();
    let is_paired = |i: usize| pairs.iter().any(|&(a, b)| a == i || b == i);
    for i in (0..n).filter(|&i| moves(i) || is_paired(i)) {
        let part = *of_root[root(&mut parents, i)].get_or_insert_with(|| {
            all.push(Part {
                variables: Vec::new(),
                pairs: Vec::new(),
            });
            all.len() - 1
        });
        places[i] = all[part].variables.len();
        all[part].variables.push(i);
    }
    for &(i, j) in pairs {
        let part = of_root[root(&mut parents, i)];
        // both sides are in it
        if let Some(part) = part {
            all[part].pairs.push((places[i], places[j]));
        }
    }
    all
}

/// The one that stands for all that `i` is united with.
fn root(parents: &mut [usize], mut i: usize) -> usize {
    while parents[i] != i {
        parents[i] = parents[parents[i]];
        i = parents[i];
    }
    i
}

fn unite(parents: &mut [usize], i: usize, j: usize) {
    let (i, j) = (root(parents, i), root(parents, j));
    parents[i.max(j)] = i.min(j);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `d_0 + d_1 <= 0`, `d_2 - d_3 = 0` and `d_0 + d_2 <= room`, all within one of zero, the last variable held.
    fn program(room: f64) -> LinearProgram {
        LinearProgram {
            gradient: vec![1.0, 2.0, 3.0, 4.0, 5.0],
            pattern: vec![(0, 0), (0, 1), (1, 2), (1, 3), (2, 0), (2, 2)],
            values: vec![1.0, 1.0, 1.0, -1.0, 1.0, 1.0],
            row_lower: vec![f64::NEG_INFINITY, 0.0, f64::NEG_INFINITY],
            row_upper: vec![0.0, 0.0, room],
            lower: vec![-1.0, -1.0, -1.0, -1.0, 0.0],
            upper: vec![1.0, 1.0, 1.0, 1.0, 0.0],
        }
    }

    #[test]
    fn parts_are_tied_by_rows_that_hold_and_by_pairs() {
        let variables = |room: f64, pairs: &[(usize, usize)]| -> Vec<Vec<usize>> {
            let mut program = program(room);
            let_go(&mut program, 1e-2);
            let parts = parts(&program, pairs);
            parts.into_iter().map(|part| part.variables).collect()
        };
        assert_eq!(variables(0.03, &[]), [[0, 1], [2, 3]]);
        assert_eq!(variables(0.01, &[]), [[0, 1, 2, 3]]);
        assert_eq!(variables(9.0, &[(1, 4)]), [vec![0, 1, 4], vec![2, 3]]);
    }

    #[test]
    fn of_a_part_are_its_rows_and_a_row_let_go_shortens_a_direction() {
        let mut program = program(0.5);
        let gone = let_go(&mut program, 1e-2);
        let all = parts(&program, &[(2, 3)]);
        let own = of_part(&program, &all[1]);
        assert_eq!(own.gradient, [3.0, 4.0]);
        assert_eq!(own.pattern, [(0, 0), (0, 1)]);
        assert_eq!((own.row_lower[0], own.row_upper[0]), (0.0, 0.0));
        assert_eq!(all[1].pairs, [(0, 1)]);
        // 2 where 0.5 is left
        assert_eq!(gone.longest(&[1.0, -1.0, 1.0, 1.0, 0.0]), 0.25);
        assert_eq!(gone.longest(&[-1.0, 1.0, -1.0, -1.0, 0.0]), 1.0);
    }
}
