use proptest::prelude::*;

use super::*;

/// A set as a list of booleans.
#[derive(Debug, Clone)]
struct Naive {
    rows: u16,
    columns: u16,
    cells: Vec<bool>,
}

impl Naive {
    fn at(&self, row: i32, column: i32) -> bool {
        let inside = (0..i32::from(self.rows)).contains(&row)
            && (0..i32::from(self.columns)).contains(&column);
        inside && self.cells[row as usize * usize::from(self.columns) + column as usize]
    }

    fn map(&self, f: impl Fn(i32, i32) -> bool) -> Self {
        let pixels = (0..i32::from(self.rows))
            .flat_map(|row| (0..i32::from(self.columns)).map(move |column| (row, column)));
        Self { cells: pixels.map(|(row, column)| f(row, column)).collect(), ..*self }
    }

    fn around(&self, row: i32, column: i32, radius: i32) -> impl Iterator<Item = bool> {
        (row - radius..=row + radius)
            .flat_map(move |r| (column - radius..=column + radius).map(move |c| self.at(r, c)))
    }

    fn bitmap(&self) -> Bitmap {
        let mut bitmap = Bitmap::new(self.rows, self.columns);
        for row in 0..self.rows {
            for column in 0..self.columns {
                if self.at(row.into(), column.into()) {
                    bitmap.set(row, column);
                }
            }
        }
        bitmap
    }

    fn flood(seeds: &Self, mask: &Self) -> Self {
        let mut filled = mask.map(|r, c| seeds.at(r, c) && mask.at(r, c));
        loop {
            let more = mask.map(|r, c| mask.at(r, c) && filled.around(r, c, 1).any(|near| near));
            if more.cells == filled.cells {
                return filled;
            }
            filled = more;
        }
    }
}

/// Two sets of the same size, of any density.
fn pair() -> impl Strategy<Value = [Naive; 2]> {
    (1_u16..20, 1_u16..150, 0.05..0.95_f64).prop_flat_map(|(rows, columns, share)| {
        let size = usize::from(rows) * usize::from(columns);
        let set = move || {
            let cells = prop::collection::vec(prop::bool::weighted(share), size);
            cells.prop_map(move |cells| Naive { rows, columns, cells })
        };
        [set(), set()]
    })
}

proptest! {
    #[test]
    fn sets_are_what_they_are_in_the_naive_version([a, b] in pair(), by in (-25..25, -160..160), radius in 0_u16..9) {
        let (bit_a, bit_b) = (a.bitmap(), b.bitmap());
        let naive = |f: &dyn Fn(i32, i32) -> bool| a.map(f).bitmap();
        prop_assert_eq!(bit_a.clone().or(&bit_b), naive(&|r, c| a.at(r, c) || b.at(r, c)));
        prop_assert_eq!(bit_a.clone().and(&bit_b), naive(&|r, c| a.at(r, c) && b.at(r, c)));
        prop_assert_eq!(bit_a.clone().and_not(&bit_b), naive(&|r, c| a.at(r, c) && !b.at(r, c)));
        prop_assert_eq!(bit_a.complement(), naive(&|r, c| !a.at(r, c)));
        prop_assert_eq!(bit_a.meets(&bit_b), !bit_a.clone().and(&bit_b).is_empty());
        let (down, right) = by;
        prop_assert_eq!(bit_a.shifted([down, right]), naive(&|r, c| a.at(r - down, c - right)));
        let reach = i32::from(radius);
        prop_assert_eq!(bit_a.dilated(radius), naive(&|r, c| a.around(r, c, reach).any(|x| x)));
        let rest = a.map(|r, c| !a.at(r, c));
        prop_assert_eq!(bit_a.eroded(radius), naive(&|r, c| !rest.around(r, c, reach).any(|x| x)));
        prop_assert_eq!(Bitmap::flood(&bit_b, &bit_a), Naive::flood(&b, &a).bitmap());
        prop_assert_eq!(bit_a.count() as usize, a.cells.iter().filter(|x| **x).count());
    }

    #[test]
    fn sets_are_read_back([a, _] in pair()) {
        let bitmap = a.bitmap();
        let (rows, columns) = (a.rows, a.columns);
        prop_assert_eq!(Bitmap::from_runs(rows, columns, &bitmap.runs()), Some(bitmap.clone()));
        prop_assert_eq!(Bitmap::from_bytes(rows, columns, &bitmap.to_bytes()), Some(bitmap.clone()));
        let labels: Vec<Label> =
            a.cells.iter().map(|x| if *x { Label::Road } else { Label::Ground }).collect();
        prop_assert_eq!(Bitmap::from_labels(rows, columns, &labels, Label::Road), bitmap);
    }

    #[test]
    fn pixels_components_and_bounds_agree([a, _] in pair()) {
        let bitmap = a.bitmap();
        let mut again = Bitmap::new(a.rows, a.columns);
        bitmap.pixels().for_each(|[row, column]| again.set(row, column));
        prop_assert_eq!(&again, &bitmap);
        let components = bitmap.components();
        let total: u32 = components.iter().map(Bitmap::count).sum();
        prop_assert_eq!(total, bitmap.count());
        for (index, component) in components.iter().enumerate() {
            let others = bitmap.clone().and_not(component);
            prop_assert!(!component.dilated(1).meets(&others), "component {}", index);
        }
        let rows = || bitmap.pixels().map(|[row, _]| row);
        let columns = || bitmap.pixels().map(|[_, column]| column);
        let expected = rows().min().zip(rows().max()).zip(columns().min().zip(columns().max()));
        let bounds = bitmap.bounds().map(|b| ((b.rows[0], b.rows[1]), (b.columns[0], b.columns[1])));
        prop_assert_eq!(bounds, expected);
    }

    #[test]
    fn any_runs_and_bytes_are_refused_or_read(
        runs in prop::collection::vec(any::<u32>(), 0..9), bytes in prop::collection::vec(any::<u8>(), 0..99),
    ) {
        let length: u64 = runs.iter().map(|run| u64::from(*run)).sum();
        prop_assert_eq!(Bitmap::from_runs(5, 70, &runs).is_some(), length == 350);
        if let Some(bitmap) = Bitmap::from_bytes(5, 70, &bytes) {
            prop_assert_eq!(bitmap.to_bytes(), bytes);
        }
    }
}

#[test]
fn insides_are_rectangles() {
    let inside = Bitmap::inside(5, 130, 1);
    let bounds = Rect { rows: [1, 3], columns: [1, 128] };
    assert_eq!((inside.bounds(), inside.count()), (Some(bounds), 3 * 128));
    assert_eq!(bounds.middle(), [2, 64]);
    assert!(Bitmap::inside(5, 130, 3).is_empty());
    assert_eq!(Bitmap::inside(5, 130, 2).count(), 126);
}
