//! Measured media that Mitsuba 0.6 knows by name.

use gi_core::math::Rgb;

/// Name, scattering and absorption of red, green and blue light. The media up to `Wholemilk` are from \[Jensen01b\]; their
/// scattering is the reduced one. The others are from \[Narasimhan06\].
#[rustfmt::skip]
const MEASURED: [(&str, [f32; 3], [f32; 3]); 47] = [
    ("Apple", [2.29, 2.39, 1.97], [0.003, 0.0034, 0.046]),
    ("Chicken1", [0.15, 0.21, 0.38], [0.0015, 0.077, 0.19]),
    ("Chicken2", [0.19, 0.25, 0.32], [0.0018, 0.088, 0.2]),
    ("Cream", [7.38, 5.47, 3.15], [0.0002, 0.0028, 0.0163]),
    ("Ketchup", [0.18, 0.07, 0.03], [0.061, 0.97, 1.45]),
    ("Marble", [2.19, 2.62, 3.0], [0.0021, 0.0041, 0.0071]),
    ("Potato", [0.68, 0.7, 0.55], [0.0024, 0.009, 0.12]),
    ("Skimmilk", [0.7, 1.22, 1.9], [0.0014, 0.0025, 0.0142]),
    ("Skin1", [0.74, 0.88, 1.01], [0.032, 0.17, 0.48]),
    ("Skin2", [1.09, 1.59, 1.79], [0.013, 0.07, 0.145]),
    ("Spectralon", [11.6, 20.4, 14.9], [0.0, 0.0, 0.0]),
    ("Wholemilk", [2.55, 3.21, 3.77], [0.0011, 0.0024, 0.014]),
    ("Lowfat Milk", [13.1157, 15.4445, 17.9572], [0.00287, 0.00575, 0.0115]),
    ("Reduced Milk", [13.7335, 15.6003, 17.8007], [0.00256, 0.00511, 0.01278]),
    ("Regular Milk", [18.2052, 20.3826, 22.3698], [0.00153, 0.0046, 0.01993]),
    ("Espresso", [7.78262, 8.1305, 8.53875], [4.79838, 6.57512, 8.84925]),
    ("Mint Mocha Coffee", [3.51133, 4.14383, 5.59667], [3.772, 5.82283, 7.82]),
    ("Lowfat Soy Milk", [2.03838, 2.32875, 3.90281], [0.00144, 0.00719, 0.03594]),
    ("Regular Soy Milk", [4.66325, 5.20183, 8.74575], [0.00192, 0.00958, 0.06517]),
    ("Lowfat Chocolate Milk", [9.8371, 11.4954, 13.1629], [0.0115, 0.0368, 0.1564]),
    ("Regular Chocolate Milk", [10.5685, 13.1416, 15.2202], [0.01006, 0.04313, 0.14375]),
    ("Coke", [0.00254, 0.00299, 0.0], [0.10014, 0.16503, 0.2468]),
    ("Pepsi", [0.00083, 0.00203, 0.0], [0.09164, 0.14158, 0.20729]),
    ("Sprite", [0.00011, 0.00014, 0.00014], [0.00189, 0.00183, 0.002]),
    ("Gatorade", [0.03668, 0.04488, 0.05742], [0.02479, 0.01929, 0.00888]),
    ("Chardonnay", [0.00021, 0.00033, 0.00048], [0.01078, 0.01186, 0.024]),
    ("White Zinfandel", [0.00022, 0.00033, 0.00046], [0.01207, 0.01618, 0.01984]),
    ("Merlot", [0.00081, 0.0, 0.0], [0.11632, 0.25191, 0.29434]),
    ("Budweiser Beer", [0.00029, 0.00055, 0.00059], [0.01149, 0.02491, 0.05779]),
    ("Coors Light Beer", [0.00062, 0.00127, 0.0], [0.00616, 0.01398, 0.03498]),
    ("Clorox", [0.02731, 0.03302, 0.03695], [0.00335, 0.01489, 0.0263]),
    ("Apple Juice", [0.00257, 0.00311, 0.00413], [0.01296, 0.02374, 0.05218]),
    ("Cranberry Juice", [0.00196, 0.00238, 0.00301], [0.03944, 0.09422, 0.12426]),
    ("Grape Juice", [0.00138, 0.0, 0.0], [0.10404, 0.23958, 0.29325]),
    ("Ruby Grapefruit Juice", [0.15496, 0.15391, 0.15995], [0.08587, 0.18314, 0.25262]),
    ("White Grapefruit Juice", [0.50499, 0.52742, 0.75282], [0.0138, 0.01883, 0.05678]),
    ("Shampoo", [0.00797, 0.00874, 0.01127], [0.01411, 0.04569, 0.06172]),
    ("Strawberry Shampoo", [0.00215, 0.00245, 0.00253], [0.01449, 0.05796, 0.07582]),
    ("Head & Shoulders Shampoo", [0.26747, 0.27696, 0.29574], [0.08462, 0.15688, 0.20365]),
    ("Lemon Tea Powder", [0.74489, 0.83823, 1.00158], [2.42881, 4.57573, 7.2127]),
    ("Orange Juice Powder", [0.00193, 0.00213, 0.00226], [0.00145, 0.00344, 0.00786]),
    ("Pink Lemonade Powder", [0.00123, 0.00133, 0.00131], [0.00116, 0.00237, 0.0032]),
    ("Cappuccino Powder", [12.2094, 16.4659, 29.2727], [35.8441, 49.547, 61.0844]),
    ("Salt Powder", [0.13805, 0.15677, 0.17865], [0.28415, 0.3257, 0.34148]),
    ("Sugar Powder", [0.00282, 0.00315, 0.00393], [0.01264, 0.03105, 0.05012]),
    ("Suisse Mocha Powder", [30.0848, 33.4452, 38.7191], [17.502, 27.0044, 35.4334]),
    ("Pacific Ocean Surface Water", [0.0018, 0.00183, 0.00228], [0.03184, 0.03132, 0.03015]),
];

/// Mitsuba 0.6 multiplies the table by this.
const UNIT: f32 = 100.0;

/// The coefficients of scattering and absorption of the medium `name`, in upper or lower case.
pub(super) fn coefficients(name: &str) -> Option<(Rgb, Rgb)> {
    let known = MEASURED.iter().find(|(known, ..)| known.eq_ignore_ascii_case(name.trim()))?;
    Some((Rgb::from(known.1) * UNIT, Rgb::from(known.2) * UNIT))
}

/// All names.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    MEASURED.iter().map(|(name, ..)| *name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_in_any_case() {
        let (s, a) = coefficients("SKIN1").unwrap();
        assert_eq!((s.to_array(), a.g), ([74.0, 88.0, 101.0], 17.0));
        assert!(coefficients("skin3").is_none());
    }
}
