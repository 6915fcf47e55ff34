//! Colour tables in the cache on disk.

use super::basis::{MOST_COMPONENTS, MOST_PIECES, PER_TEXEL};
use super::{BANDS, ColorBasis, ColorTable, SPECULAR_SAMPLES, TableHeader};
use crate::brdf::energy_map::EnergyMap;
use crate::cache::{EntryFormat, Kept, Payload, count, positive};
use crate::optics::factor::IndexTriple;
use crate::optics::reflectance::MeanReflectance;

impl Kept for ColorTable {
    /// The version changes whenever the table of the same key would change.
    const FORMAT: EntryFormat = EntryFormat { name: "colours", version: 20 };
    type Header = TableHeader;

    fn header(&self) -> TableHeader {
        self.header.clone()
    }

    fn payload(&self) -> Vec<&[u8]> {
        self.mips.iter().map(|mip| bytemuck::cast_slice(mip)).collect()
    }

    fn build(header: TableHeader, payload: &mut Payload<'_>) -> Option<Self> {
        if !is_sound(&header) {
            return None;
        }
        let mip = |mip: usize| {
            let side = header.grid.side >> mip;
            payload.take_halves(count(&[side, side, header.layers(), PER_TEXEL])?)
        };
        let mips = (0..header.grid.mips()).map(mip).collect::<Option<_>>()?;
        Some(Self { header, mips })
    }
}

/// Returns true if `header` is valid: the code that uses it divides by its numbers, counts with them and makes textures of its sizes. The
/// check sum finds accidental damage, not forged files.
pub(super) fn is_sound(header: &TableHeader) -> bool {
    let TableHeader {
        grid,
        basis,
        unit,
        specular,
        coherence_blur,
        budget: _,
        series_error,
        basis_error,
        effective_orders,
        mean_reflectance,
        indices,
        energy,
    } = header;
    grid.is_sound()
        && positive(&[grid.extent, grid.growth, *unit, *coherence_blur, *effective_orders])
        && mean_reflectance.as_ref().is_none_or(MeanReflectance::is_sound)
        && indices.as_ref().is_none_or(IndexTriple::is_sound)
        && energy.as_ref().is_none_or(|points| EnergyMap::are_sound(points))
        && [grid.finest, *series_error, *basis_error].into_iter().all(|x| x.is_finite() && x >= 0.0)
        && is_sound_basis(basis)
        && specular.variances.len() == BANDS
        && positive(&specular.variances)
        && specular.weights.len() == specular.variances.len()
        && specular.weights.iter().all(|band| {
            band.len() == SPECULAR_SAMPLES && band.iter().flatten().all(|weight| weight.is_finite())
        })
}

fn is_sound_basis(basis: &ColorBasis) -> bool {
    let ColorBasis { pieces, components, cubics } = basis;
    (1..=MOST_PIECES).contains(pieces)
        && (PER_TEXEL..=MOST_COMPONENTS).contains(components)
        && components.is_multiple_of(PER_TEXEL)
        && cubics.len() == pieces * components
        && cubics.iter().flatten().flatten().all(|x| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::budget::{ErrorBudget, MeanBudget};
    use crate::cache::{Key, Store, read, seal};
    use crate::optics::energy::DirectionGrid;
    use crate::optics::material::Material;
    use crate::optics::reflectance::{Film, Reflectance};
    use crate::optics::spectrum::Illuminant;
    use crate::surface::HeightField;
    use crate::table::{Specular, TableGrid, TableSettings};
    use half::f16;
    use serde_json::{Value, json};

    fn sample() -> ColorTable {
        let grid = TableGrid { side: 32, levels: 4, extent: 2.0, finest: 0.0, growth: 0.1 };
        let specular = Specular {
            variances: (1..=BANDS).map(|i| 0.1 * i as f64).collect(),
            weights: vec![vec![[0.1, 0.2, 0.3]; SPECULAR_SAMPLES]; BANDS],
        };
        let header = TableHeader {
            grid,
            basis: ColorBasis { pieces: 2, components: 8, cubics: vec![[[0.5; 4]; 3]; 16] },
            unit: 0.3,
            specular,
            coherence_blur: 1e-5,
            budget: ErrorBudget::of_directions(1e-2).mean,
            series_error: 1e-3,
            basis_error: 1e-3,
            effective_orders: 3.0,
            mean_reflectance: Some(MeanReflectance::new(&Reflectance::Schlick(1.5))),
            indices: Some(IndexTriple::of(&Reflectance::default())),
            energy: Some(vec![[0.5, 1.0]; DirectionGrid::COUNT]),
        };
        let numbers =
            |side: usize| (0..side * side * 2 * 2 * 8).map(|i| f16::from_f32(i as f32 * 0.01)).collect();
        ColorTable { header, mips: vec![numbers(32), numbers(16)] }
    }

    fn found(header: &Value, payload: &[u8]) -> Option<ColorTable> {
        let key = Key::named("colours");
        let file = seal(&ColorTable::FORMAT, &key, header, payload);
        let size = file.len() as u64;
        read(&mut file.as_slice(), size, &ColorTable::FORMAT, &key, 1 << 28, ColorTable::build)
    }

    #[test]
    fn a_table_comes_back_from_the_disk_as_it_went() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::at(folder.path().join("cache"), 1 << 28);
        let (key, table) = (Key::named("colours"), sample());
        assert!(store.load_kept::<ColorTable>(&key, 1 << 28).is_none());
        store.save_kept(&key, &table).unwrap();
        assert_eq!(store.load_kept(&key, 1 << 28), Some(table));
        assert!(store.load_kept::<ColorTable>(&key, 1).is_none(), "more than the memory limit");
    }

    #[test]
    fn numbers_that_no_table_has_make_a_file_absent_in_spite_of_its_check_sum() {
        let table = sample();
        let payload = table.payload().concat();
        let sound = serde_json::to_value(table.header()).unwrap();
        assert!(found(&sound, &payload) == Some(table));
        let with = |path: &str, value: Value| {
            let mut header = sound.clone();
            *header.pointer_mut(path).unwrap() = value;
            found(&header, &payload).is_some()
        };
        for path in ["/unit", "/grid/extent", "/grid/growth", "/specular/variances/3"] {
            assert!(with(path, json!(0.5)), "{path}");
            for value in [json!(0.0), json!(-1.0), json!(null), json!("1")] {
                assert!(!with(path, value.clone()), "{path} {value}");
            }
        }
        for path in ["/grid/side", "/grid/levels", "/basis/pieces", "/basis/components"] {
            for value in [json!(0), json!(1), json!(33), json!(-1), json!(1u64 << 40), json!(u64::MAX)] {
                assert!(!with(path, value.clone()), "{path} {value}");
            }
        }
        for path in ["/specular/variances", "/specular/weights", "/specular/weights/2", "/basis/cubics"] {
            assert!(!with(path, json!([])), "{path}");
        }
        for path in ["/indices/n/1", "/energy/7/1"] {
            assert!(with(path, json!(0.5)), "{path}");
            for value in [json!(-1.0), json!(null), json!("1"), json!(1e300)] {
                assert!(!with(path, value.clone()), "{path} {value}");
            }
        }
        for (path, value) in
            [("/indices/k/0", json!(-0.1)), ("/indices/n", json!([1.5])), ("/energy", json!([[1.0, 1.0]]))]
        {
            assert!(!with(path, value), "{path}");
        }
        assert!(!with("/basis/cubics/7/1/2", json!(1e300)));
        assert!(!with("/specular/weights/1/5/2", json!(1e300)) && !with("/grid/finest", json!(-1.0)));
        for place in [0, payload.len() - 2] {
            for bits in [f16::NAN, f16::INFINITY, f16::NEG_INFINITY] {
                let mut damaged = payload.clone();
                damaged[place..place + 2].copy_from_slice(&bits.to_ne_bytes());
                assert!(found(&sound, &damaged).is_none(), "{bits} at {place}");
            }
        }
        assert!(
            found(&sound, &payload[2..]).is_none()
                && found(&sound, &[&payload[..], &[0; 2]].concat()).is_none()
        );
    }

    /// Returns gold below a film of this thickness.
    fn gold(film: Option<f64>) -> Reflectance {
        let material = Material::from_name_or_file("gold").unwrap();
        Reflectance::of_material(material, film.map(|thickness| Film { thickness, index: 1.5 }))
    }

    #[test]
    fn every_setting_but_the_memory_changes_the_key() {
        let field = HeightField::new(4, 4, [0.1, 0.1], vec![0.0; 16]).unwrap();
        let key = |settings: &TableSettings| Key::new(&ColorTable::FORMAT, settings, &field).unwrap();
        let all = TableSettings {
            illuminant: Illuminant::D65,
            reflectance: None,
            wavelengths: None,
            budget: ErrorBudget::of_directions(1e-2).mean,
            finest: 0.0,
            side_limit: 16_384,
            memory_limit: 1 << 28,
        };
        let with = |budget| TableSettings { budget, ..all.clone() };
        let others = [
            TableSettings { illuminant: Illuminant::A, ..all.clone() },
            TableSettings { reflectance: Some(gold(None)), ..all.clone() },
            TableSettings { reflectance: Some(gold(Some(0.1))), ..all.clone() },
            TableSettings { reflectance: Some(gold(Some(0.2))), ..all.clone() },
            TableSettings { wavelengths: Some(20), ..all.clone() },
            with(MeanBudget { wavelengths: 2e-3, ..all.budget }),
            with(MeanBudget { reading: 2e-2, ..all.budget }),
            with(MeanBudget { averaging: 2.0, ..all.budget }),
            with(MeanBudget { most_averaging: 2.0, ..all.budget }),
            with(MeanBudget { places: 16, ..all.budget }),
            with(MeanBudget { basis: 2e-2, ..all.budget }),
            TableSettings { finest: 1e-3, ..all.clone() },
            TableSettings { side_limit: 8192, ..all.clone() },
            all.clone(),
        ];
        let keys: std::collections::HashSet<Key> = others.iter().map(key).collect();
        assert_eq!(keys.len(), others.len());
        assert_eq!(key(&TableSettings { memory_limit: 1, ..all.clone() }), key(&all));
    }
}
