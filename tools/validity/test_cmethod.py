"""Judges of the C method: a published grating, an independent method, energy and flat mirrors. Run: python -m unittest test_cmethod"""

import unittest

import grcwa
import numpy as np

from cmethod import efficiencies
from profiles import blaze, lamellar, sinusoid

ALUMINIUM = 0.958 + 6.69j


def staircase(curve, sine, index, size, layers):
    """Returns reflected shares by RCWA: the profile in `layers` steps. {"te", "tm"} to {order: share}."""
    heights = np.sort(curve.z)
    low, high = heights[0], heights[-1]
    x = (np.arange(2000) + 0.5) / 2000 * curve.period
    z = np.interp(x, curve.x, curve.z, period=curve.period)
    thickness = (high - low) / layers
    shares = {}
    for polarisation in ["te", "tm"]:
        rcwa = grcwa.obj(size, [curve.period, 0], [0, 1e-3], 1.0, np.arcsin(sine), 0.0, verbose=0)
        rcwa.Add_LayerUniform(0, 1.0)
        for _ in range(layers):
            rcwa.Add_LayerGrid(thickness, len(x), 1)
        rcwa.Add_LayerUniform(0, index**2)
        rcwa.Init_Setup()
        middles = high - (np.arange(layers) + 0.5) * thickness
        rcwa.GridLayer_geteps(np.concatenate([np.where(z > m, index**2, 1.0) for m in middles]))
        te = float(polarisation == "te")
        rcwa.MakeExcitationPlanewave(p_amp=1 - te, p_phase=0, s_amp=te, s_phase=0, order=0)
        reflected, _ = rcwa.RT_Solve(normalize=1, byorder=1)
        shares[polarisation] = dict(zip(rcwa.G[:, 0], np.real(reflected)))
    return shares


class CMethod(unittest.TestCase):
    def test_perfectly_conducting_sinusoid_has_its_published_orders(self):
        # Integral method: period 5 µm, amplitude 50 nm, 530 nm, normal incidence, TE, orders 0, 1, 2.
        found = efficiencies(sinusoid(5 / 0.53, 0.1 / 0.53), 0.0, None, 61)
        te = dict(zip(found.orders, found.reflected["te"]))
        for order, share in [(0, 0.4624), (1, 0.2442), (-1, 0.2442), (2, 0.0237)]:
            self.assertAlmostEqual(te[order], share, delta=6e-5)
        self.assertLess(found.energy, 1e-10)

    def test_dielectrics_agree_with_rcwa(self):
        for curve in [sinusoid(3, 0.3), sinusoid(1.5, 0.5), blaze(2, 0.3), lamellar(1.5, 0.25)]:
            found = efficiencies(curve, np.sin(0.6), 1.5, 81)
            rcwa = staircase(curve, np.sin(0.6), 1.5, 61, 40)
            for polarisation, shares in found.reflected.items():
                total = shares.sum()
                for order, share in zip(found.orders, shares):
                    self.assertLess(abs(share - rcwa[polarisation][order]), 5e-3 * total, (curve.height, order))

    def test_flat_mirrors_have_fresnels_reflectance(self):
        cos = np.sqrt(1 - 0.36)
        for index in [1.5, ALUMINIUM]:
            inside = np.sqrt(index**2 - 0.36)
            found = efficiencies(sinusoid(3, 1e-9), 0.6, index, 21)
            place = list(found.orders).index(0)
            te = abs((cos - inside) / (cos + inside)) ** 2
            tm = abs((index**2 * cos - inside) / (index**2 * cos + inside)) ** 2
            self.assertAlmostEqual(found.reflected["te"][place], te, delta=1e-8)
            self.assertAlmostEqual(found.reflected["tm"][place], tm, delta=1e-8)

    def test_more_coefficients_change_little_and_energy_is_kept(self):
        for profile in [sinusoid, blaze, lamellar]:
            for index in [1.5, ALUMINIUM]:
                few, many = (efficiencies(profile(1.5, 0.4), 0.5, index, size) for size in [61, 121])
                self.assertLess(max(few.energy, many.energy), 1e-4)
                for polarisation in ["te", "tm"]:
                    change = few.reflected[polarisation] - many.reflected[polarisation]
                    self.assertLess(abs(change).max(), 1e-3, (profile.__name__, index))


if __name__ == "__main__":
    unittest.main()
