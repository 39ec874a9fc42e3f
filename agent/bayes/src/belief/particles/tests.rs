use super::*;

const GROUND: Ground = Ground { size_m: [1000.0, 600.0] };

/// Φ.
fn normal_below(z: f64) -> f64 {
    0.5 * libm::erfc(-z * std::f64::consts::FRAC_1_SQRT_2)
}

/// The greatest difference between Φ and the share of numbers that are less (Kolmogorov's statistic).
fn greatest_difference(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    let count = numbers.len() as f64;
    let difference = |(i, z): (usize, &f64)| {
        let p = normal_below(*z);
        (p - i as f64 / count).max((i + 1) as f64 / count - p)
    };
    numbers.iter().enumerate().map(difference).fold(0.0, f64::max)
}

/// Moments, tails and distribution of the table itself.
#[test]
fn the_table_is_nearly_normal() {
    let numbers: Vec<f64> = NORMAL.iter().map(|z| f64::from(*z)).collect();
    let moment =
        |power: i32| numbers.iter().map(|z| z.powi(power)).sum::<f64>() / numbers.len() as f64;
    assert!(moment(1).abs() < 1e-7 && moment(3).abs() < 1e-6, "{} {}", moment(1), moment(3));
    assert!((moment(2) - 1.0).abs() < 1e-6, "{}", moment(2));
    assert!((moment(4) - 3.0).abs() < 0.03, "{}", moment(4));
    let beyond =
        |z: f64| numbers.iter().filter(|x| x.abs() > z).count() as f64 / numbers.len() as f64;
    for z in [1.0, 2.0, 3.0, 3.4] {
        assert!((beyond(z) - 2.0 * normal_below(-z)).abs() < 3e-4, "{z}: {}", beyond(z));
    }
    assert_eq!(beyond(3.7), 0.0);
    let difference = greatest_difference(numbers);
    assert!(difference < 1.9e-4, "{difference}");
}

/// Steps of particles are normal, for one step and the sum of four, and independent between axes, steps and keys.
#[test]
fn steps_are_normal_and_independent() {
    let count = 20_000;
    let walks = |key: u8| {
        let mut particles = Particles::new(GROUND, count, [key; 32]);
        particles.x.fill(0.0);
        particles.y.fill(0.0);
        let mut places = Vec::new();
        for step in 1..=4 {
            particles.walk(Step(step), 2.0);
            places.push([particles.x.clone(), particles.y.clone()]);
        }
        places
    };
    // Kolmogorov's statistic exceeds this in one of 1000 samples.
    let critical = 1.95 / f64::from(count).sqrt();
    let (walk, other) = (walks(1), walks(2));
    for (places, sigma_m) in [(&walk[0], 2.0), (&walk[3], 4.0), (&other[0], 2.0)] {
        for axis in places {
            let steps: Vec<f64> = axis.iter().map(|x| f64::from(*x) / sigma_m).collect();
            let difference = greatest_difference(steps);
            assert!(difference < critical, "{difference} {critical}");
        }
    }
    let second: Vec<f32> = walk[1][0].iter().zip(&walk[0][0]).map(|(b, a)| b - a).collect();
    for (a, b) in [(&walk[0][0], &walk[0][1]), (&walk[0][0], &second), (&walk[0][0], &other[0][0])]
    {
        let products = a.iter().zip(b).map(|(a, b)| f64::from(a * b) / 4.0);
        let correlation = products.sum::<f64>() / f64::from(count);
        assert!(correlation.abs() < 3.5 / f64::from(count).sqrt(), "{correlation}");
    }
}

/// At the border particles turn back, and none is lost, however long the step.
#[test]
fn particles_stay_in_the_region() {
    for sigma_m in [1.0, 100.0, 5000.0] {
        let mut particles = Particles::new(GROUND, 5000, [3; 32]);
        (1..30).for_each(|step| particles.walk(Step(step), sigma_m));
        assert!(particles.points().all(|[x, y]| x.abs() <= 500.0 && y.abs() <= 300.0));
        let Gaussian { mean, covariance } = particles.gaussian();
        assert!(mean[0].abs() < 25.0 && mean[1].abs() < 15.0, "{mean:?}");
        let uniform = GROUND.size_m.map(|size| size * size / 12.0);
        assert!((covariance[0] / uniform[0] - 1.0).abs() < 0.06, "{sigma_m} {covariance:?}");
        assert!((covariance[2] / uniform[1] - 1.0).abs() < 0.06, "{sigma_m} {covariance:?}");
    }
}

/// χ² of the particles in 100 cells of equal area, for numbers of particles that strips do not divide.
#[test]
fn particles_are_spread_evenly_at_the_start() {
    for count in [1, 37, 500, 6400, 9999] {
        let particles = Particles::new(GROUND, count, [5; 32]);
        assert_eq!(particles.points().count(), count as usize);
        let mut cells = [0.0; 100];
        for [x, y] in particles.points() {
            cells[(x / 100.0 + 5.0) as usize + 10 * (y / 60.0 + 5.0) as usize] += 1.0;
        }
        let expected = f64::from(count) / 100.0;
        let chi_squared: f64 = cells.iter().map(|n: &f64| (n - expected).powi(2) / expected).sum();
        assert!(chi_squared < 149.0, "{count}: {chi_squared}");
    }
}

#[test]
fn mean_and_covariance_are_those_of_the_points() {
    for count in [1, 7, 8, 1003] {
        let particles = Particles::new(GROUND, count, [6; 32]);
        let mean_of = |value: &dyn Fn([f64; 2]) -> f64| {
            particles.points().map(value).sum::<f64>() / f64::from(count)
        };
        let [mx, my] = [mean_of(&|p| p[0]), mean_of(&|p| p[1])];
        let Gaussian { mean, covariance } = particles.gaussian();
        let product = mean_of(&|[x, y]| (x - mx) * (y - my));
        assert!((mean[0] - mx).hypot(mean[1] - my) < 1e-9);
        assert!((covariance[1] - product).abs() < 1e-6, "{covariance:?} {product}");
    }
}

/// Systematic resampling: each is chosen as often as its weight says, rounded up or down.
#[test]
fn the_chosen_are_in_proportion_to_their_weights() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for count in [1, 2, 33, 6400] {
        let mut weights: Vec<f32> = (0..count).map(|_| rng.random::<f32>().powi(8)).collect();
        weights[count / 3] = 1.0;
        let total: f64 = weights.iter().map(|w| f64::from(*w)).sum();
        for shift in [0, 1, 0x8000_0000, u32::MAX] {
            let mut x: Vec<f32> = (0..count).map(|i| i as f32).collect();
            let mut y = x.clone();
            resampling::systematic(&weights, shift, [&mut x, &mut y]);
            assert!(x == y && x.len() == count && x.is_sorted());
            let mut copies = vec![0.0; count];
            x.iter().for_each(|index| copies[*index as usize] += 1.0);
            for (copies, weight) in copies.into_iter().zip(&weights) {
                let expected = f64::from(*weight) * count as f64 / total;
                assert!((expected - copies).abs() < 1.01, "{count} {shift}: {copies} {expected}");
            }
        }
    }
}

/// One that weighs nothing beside the others is not chosen, wherever it is.
#[test]
fn what_weighs_nothing_is_not_chosen() {
    for one in 0..5 {
        let mut weights = [1e-30; 5];
        weights[one] = 1.0;
        for shift in [0, u32::MAX] {
            let mut x: Vec<f32> = (0..5).map(|i| i as f32).collect();
            let mut y = x.clone();
            resampling::systematic(&weights, shift, [&mut x, &mut y]);
            assert_eq!(x, [one as f32; 5]);
        }
    }
}
