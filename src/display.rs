//! Display power of an image: channel means of linear RGB times a panel's coefficients.
