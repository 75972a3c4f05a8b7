//! The list of events of a run in bounded memory.

/// Events that a run lists, at most: some hundred megabytes of the largest scenes.
const MOST: usize = 200_000;

/// Which rows of a list that grows are kept: one of so many, evenly, once there are too many.
#[derive(Debug, Clone, Copy)]
pub(super) struct EventLog {
    /// Of all rows so far every so many are kept.
    stride: usize,
    /// Rows at the front that have been through this: those with the numbers 0, `stride`, twice that, and so on.
    kept: usize,
    /// Rows that there were when they had.
    seen: usize,
    most: usize,
}

impl Default for EventLog {
    fn default() -> Self {
        Self::of(MOST)
    }
}

impl EventLog {
    /// A list of at most so many rows.
    fn of(most: usize) -> Self {
        Self {
            stride: 1,
            kept: 0,
            seen: 0,
            most,
        }
    }

    /// All rows so far, of which `listed` are in the list.
    pub(super) fn count(&self, listed: usize) -> usize {
        self.seen + (listed - self.kept)
    }

    /// Leaves out rows where there are too many.
    pub(super) fn tidy<T>(&mut self, rows: &mut Vec<T>) {
        if rows.len() <= self.most {
            return;
        }
        let count = self.count(rows.len());
        let (stride, kept, seen) = (self.stride, self.kept, self.seen);
        let number = |k: usize| match k.checked_sub(kept) {
            None => k * stride,
            Some(since) => seen + since,
        };
        while count.div_ceil(self.stride) > self.most / 2 {
            self.stride *= 2;
        }
        let mut k = 0;
        rows.retain(|_| {
            k += 1;
            number(k - 1).is_multiple_of(self.stride)
        });
        (self.kept, self.seen) = (rows.len(), count);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_list_keeps_rows_at_even_distances_and_their_count() {
        let mut log = EventLog::of(100);
        let mut rows = Vec::new();
        for row in 0..12_345 {
            rows.push(row);
            if row % 3 == 0 {
                log.tidy(&mut rows);
            }
            assert!(rows.len() <= 102);
        }
        assert_eq!(log.count(rows.len()), 12_345);
        log.tidy(&mut rows);
        let distance = rows[1] - rows[0];
        let even = rows[..log.kept]
            .windows(2)
            .all(|pair| pair[1] - pair[0] == distance);
        assert!(even && rows[0] == 0 && distance == log.stride);
        assert!(rows.len() >= 40);
    }
}
