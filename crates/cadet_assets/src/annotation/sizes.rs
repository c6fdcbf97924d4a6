//! How long, wide and high the boxes of KITTI's labels are: mixtures of Gaussians, fitted by expectation maximization to
//! every label of a class in the 7,481 training frames.

use cadet_base::math::DVec3;
use cadet_base::rng::Stream;

/// Sizes of a class, meters, none beyond those that were labeled.
pub(crate) struct Mixture {
    components: &'static [Component],
    least_lwh: DVec3,
    most_lwh: DVec3,
}

struct Component {
    weight: f64,
    mean_lwh: [f64; 3],
    sd_lwh: [f64; 3],
    /// Of length and width, length and height, width and height.
    correlation: [f64; 3],
}

impl Mixture {
    /// Length, width, height.
    pub fn draw(&self, s: &mut Stream) -> DVec3 {
        let weights: Vec<f64> = self.components.iter().map(|c| c.weight).collect();
        loop {
            let size = self.components[s.weighted(&weights)].draw(s);
            if size.cmpge(self.least_lwh).all() && size.cmple(self.most_lwh).all() {
                return size;
            }
        }
    }
}

impl Component {
    fn draw(&self, s: &mut Stream) -> DVec3 {
        let z = [s.normal(), s.normal(), s.normal()];
        // The Cholesky factor of the correlations.
        let [lw, lh, wh] = self.correlation;
        let w2 = (1.0 - lw * lw).sqrt();
        let h2 = (wh - lw * lh) / w2;
        let h3 = (1.0 - lh * lh - h2 * h2).max(0.0).sqrt();
        let unit = [z[0], lw * z[0] + w2 * z[1], lh * z[0] + h2 * z[1] + h3 * z[2]];
        DVec3::from_array(std::array::from_fn(|k| self.mean_lwh[k] + self.sd_lwh[k] * unit[k]))
    }
}

const fn component(weight: f64, mean_lwh: [f64; 3], sd_lwh: [f64; 3], correlation: [f64; 3]) -> Component {
    Component { weight, mean_lwh, sd_lwh, correlation }
}

/// 28,742 labels.
pub(crate) const CARS: Mixture = Mixture {
    components: &[
        component(0.263, [4.138, 1.619, 1.462], [0.255, 0.074, 0.072], [0.46, 0.04, 0.09]),
        component(0.176, [3.663, 1.614, 1.522], [0.257, 0.096, 0.085], [0.38, -0.07, 0.34]),
        component(0.146, [3.668, 1.626, 1.482], [0.123, 0.068, 0.104], [0.55, 0.41, 0.32]),
        component(0.107, [3.991, 1.653, 1.674], [0.225, 0.064, 0.125], [0.25, -0.33, -0.33]),
        component(0.079, [3.379, 1.559, 1.433], [0.141, 0.082, 0.054], [0.03, -0.18, -0.26]),
        component(0.050, [4.393, 1.659, 1.466], [0.236, 0.148, 0.058], [0.25, -0.15, 0.24]),
        component(0.039, [4.430, 1.718, 1.703], [0.089, 0.100, 0.091], [-0.21, -0.81, 0.40]),
        component(0.034, [4.115, 1.711, 1.480], [0.105, 0.099, 0.107], [-0.09, 0.62, 0.05]),
        component(0.033, [4.555, 1.756, 1.871], [0.325, 0.111, 0.216], [0.15, -0.14, 0.41]),
        component(0.030, [3.343, 1.595, 1.532], [0.247, 0.181, 0.110], [0.54, -0.08, 0.22]),
        component(0.026, [3.359, 1.467, 1.547], [0.702, 0.119, 0.079], [-0.70, 0.09, 0.29]),
        component(0.018, [3.088, 1.720, 1.593], [0.093, 0.059, 0.095], [-0.83, 0.46, -0.50]),
    ],
    least_lwh: DVec3::new(2.19, 1.14, 1.14),
    most_lwh: DVec3::new(6.67, 2.04, 2.48),
};

/// 2,914 labels, of no more than 143 sizes.
pub(crate) const VANS: Mixture = Mixture {
    components: &[
        component(0.293, [5.875, 2.025, 2.577], [0.498, 0.099, 0.175], [0.40, 0.50, 0.22]),
        component(0.184, [4.527, 1.814, 1.979], [0.106, 0.052, 0.083], [-0.01, -0.61, -0.23]),
        component(0.137, [4.087, 1.708, 1.821], [0.237, 0.085, 0.064], [-0.17, 0.36, 0.46]),
        component(0.127, [4.696, 1.924, 2.036], [0.406, 0.141, 0.135], [0.78, 0.49, 0.02]),
        component(0.099, [4.684, 2.033, 2.299], [0.819, 0.285, 0.298], [0.98, 0.92, 0.90]),
        component(0.109, [5.904, 1.911, 2.212], [0.577, 0.056, 0.296], [0.46, 0.98, 0.34]),
        component(0.051, [5.089, 1.708, 2.161], [0.132, 0.080, 0.119], [-0.91, 0.96, -0.90]),
    ],
    least_lwh: DVec3::new(3.18, 1.52, 1.65),
    most_lwh: DVec3::new(6.91, 2.52, 2.91),
};

/// 1,094 labels, of no more than 33 sizes: small trucks, trucks of two axles, tall and long ones, city buses, semi-trailers.
pub(crate) const TRUCKS: Mixture = Mixture {
    components: &[
        component(0.099, [5.95, 2.25, 2.59], [0.36, 0.14, 0.17], [0.60, 0.05, -0.10]),
        component(0.122, [7.14, 2.42, 3.34], [0.16, 0.20, 0.17], [0.30, 0.10, 0.30]),
        component(0.045, [7.48, 2.47, 3.06], [0.08, 0.03, 0.14], [0.20, 0.0, 0.0]),
        component(0.146, [7.98, 2.50, 3.51], [0.09, 0.13, 0.08], [0.10, -0.20, 0.20]),
        component(0.055, [8.74, 2.53, 3.41], [0.10, 0.17, 0.09], [0.10, 0.20, 0.80]),
        component(0.037, [9.05, 2.96, 4.17], [0.50, 0.03, 0.03], [0.70, 0.50, 0.0]),
        component(0.163, [10.80, 2.88, 3.53], [0.05, 0.03, 0.02], [0.50, 0.0, -0.50]),
        component(0.016, [11.85, 2.56, 3.00], [0.05, 0.07, 0.03], [0.0, 0.0, 0.0]),
        component(0.281, [12.34, 2.63, 2.85], [0.04, 0.015, 0.02], [0.0, 0.0, 0.0]),
        component(0.004, [13.60, 2.45, 3.28], [0.10, 0.03, 0.05], [0.0, 0.0, 0.0]),
        component(0.070, [16.51, 2.52, 4.04], [0.15, 0.04, 0.02], [0.80, 0.0, 0.0]),
    ],
    least_lwh: DVec3::new(5.2, 2.0, 2.25),
    most_lwh: DVec3::new(17.0, 3.05, 4.3),
};

/// 973 labels, of no more than 58 sizes: motorbikes, trailers low and tall, caravans, platforms, and long trailers, which
/// find no parking place.
pub(crate) const MISC: Mixture = Mixture {
    components: &[
        component(0.255, [1.88, 0.62, 1.36], [0.20, 0.13, 0.22], [0.20, 0.10, 0.50]),
        component(0.033, [2.78, 0.87, 1.43], [0.14, 0.07, 0.20], [-0.60, 0.50, -0.80]),
        component(0.130, [2.24, 1.36, 1.52], [0.17, 0.13, 0.13], [0.70, 0.30, 0.20]),
        component(0.110, [2.48, 1.70, 1.05], [0.20, 0.38, 0.13], [0.70, 0.20, 0.10]),
        component(0.058, [1.65, 1.40, 2.29], [0.11, 0.11, 0.13], [-0.80, -0.80, 0.80]),
        component(0.096, [2.47, 1.70, 2.15], [0.16, 0.23, 0.11], [0.60, 0.60, 0.80]),
        component(0.068, [3.52, 2.07, 2.80], [0.40, 0.07, 0.06], [-0.80, 0.80, -0.70]),
        component(0.130, [5.49, 2.12, 2.65], [0.27, 0.10, 0.18], [0.40, 0.50, 0.10]),
        component(0.037, [5.82, 2.39, 0.95], [0.06, 0.03, 0.03], [0.0, 0.0, 0.0]),
        component(0.080, [12.10, 2.62, 3.68], [0.46, 0.06, 0.21], [0.95, 0.95, 0.90]),
    ],
    least_lwh: DVec3::new(1.4, 0.42, 0.80),
    most_lwh: DVec3::new(12.8, 2.75, 4.0),
};

/// 4,487 labels, of people who walk and who stand.
pub(crate) const PEOPLE: Mixture = Mixture {
    components: &[
        component(0.498, [0.953, 0.599, 1.757], [0.153, 0.094, 0.111], [0.11, 0.53, 0.02]),
        component(0.216, [0.498, 0.631, 1.735], [0.113, 0.162, 0.108], [0.53, 0.09, 0.20]),
        component(0.138, [1.002, 0.852, 1.804], [0.082, 0.075, 0.060], [-0.16, 0.09, 0.24]),
        component(0.135, [0.797, 0.746, 1.789], [0.111, 0.102, 0.122], [0.68, -0.45, -0.76]),
        component(0.013, [1.100, 0.549, 1.560], [0.412, 0.128, 0.277], [0.90, 0.98, 0.93]),
    ],
    least_lwh: DVec3::new(0.20, 0.30, 1.14),
    most_lwh: DVec3::new(1.44, 1.20, 2.01),
};

/// 1,627 labels, of no more than 108 sizes.
pub(crate) const CYCLISTS: Mixture = Mixture {
    components: &[
        component(0.279, [1.926, 0.601, 1.791], [0.122, 0.052, 0.063], [0.00, 0.00, -0.01]),
        component(0.228, [1.785, 0.685, 1.749], [0.060, 0.097, 0.042], [-0.56, 0.62, -0.48]),
        component(0.200, [1.575, 0.604, 1.723], [0.199, 0.108, 0.130], [0.63, 0.44, 0.55]),
        component(0.178, [1.699, 0.516, 1.723], [0.041, 0.094, 0.109], [0.07, 0.23, -0.53]),
        component(0.084, [1.675, 0.396, 1.628], [0.110, 0.065, 0.025], [0.91, -0.55, -0.55]),
        component(0.031, [1.968, 0.871, 1.638], [0.045, 0.022, 0.045], [-0.40, 0.80, -0.40]),
    ],
    least_lwh: DVec3::new(1.19, 0.34, 1.41),
    most_lwh: DVec3::new(2.17, 0.93, 2.09),
};

/// 222 labels of people who sit, of no more than 33 sizes.
pub(crate) const SITTERS: Mixture = Mixture {
    components: &[
        component(0.704, [0.684, 0.610, 1.251], [0.089, 0.076, 0.083], [0.47, 0.15, 0.10]),
        component(0.247, [1.132, 0.520, 1.269], [0.180, 0.038, 0.067], [-0.57, 0.57, -0.39]),
        component(0.050, [0.830, 0.750, 1.640], [0.030, 0.030, 0.030], [0.0, 0.0, 0.0]),
    ],
    least_lwh: DVec3::new(0.50, 0.45, 1.05),
    most_lwh: DVec3::new(1.40, 0.80, 1.65),
};
