"""SSIM by scikit-image for the image pairs of tests/compare/figures.rs.

    pip install scikit-image==0.26.0
    python3 tests/compare/ssim_oracle.py
"""

import numpy as np
from skimage.metrics import structural_similarity

y, x = np.mgrid[0:40, 0:53].astype(np.float64)
reference = 1.5 + np.sin(0.4 * x) * np.cos(0.3 * y)
test = 1.5 + 0.9 * np.sin(0.4 * x + 0.2) * np.cos(0.3 * y) + 0.1 * np.sin(2.1 * x + 1.7 * y)
reference, test = [image.astype(np.float32).astype(np.float64) for image in (reference, test)]
# The 99th percentile as the Rust code ranks it.
dynamic_range = np.sort(reference.ravel())[int(0.99 * reference.size)]
ssim = structural_similarity(
    reference,
    test,
    gaussian_weights=True,
    sigma=1.5,
    use_sample_covariance=False,
    data_range=dynamic_range,
)
print(f"{dynamic_range:.9f} {ssim:.12f}")
