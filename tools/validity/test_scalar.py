"""Judges of scalar theory: flat mirrors, reciprocity, shallow gratings by the C method, and energy. Run: python -m unittest test_scalar"""

import unittest

import numpy as np

import scalar
from cmethod import efficiencies
from profiles import blaze, sinusoid

ALUMINIUM = 0.958 + 6.69j


class Scalar(unittest.TestCase):
    def test_the_mirror_direction_has_fresnels_reflectance_in_both_theories(self):
        for index in [1.5, ALUMINIUM]:
            for sine in [-0.9, 0.0, 0.5, 0.98]:
                cos = np.sqrt(1 - sine**2)
                for factor in scalar.FACTORS.values():
                    for found, flat in zip(factor(index, sine, sine), scalar.fresnel(index, cos)):
                        self.assertAlmostEqual(found / (4 * cos**2), flat, delta=1e-12)

    def test_shares_are_reciprocal_with_the_limit_too(self):
        # An order sent back along its way gives the light back that it had.
        curve, index, sine = blaze(1.7, 0.4), ALUMINIUM, 0.8
        orders = np.arange(-3, 1)
        for theory in scalar.THEORIES:
            forth = scalar.shares(theory, curve, sine, index, orders)
            for place, order in enumerate(orders):
                out = sine + order / curve.period
                back = np.arange(-9, 10)
                back = back[abs(-out + back / curve.period) < 1]
                returned = scalar.shares(theory, curve, -out, index, back)
                for polarisation in scalar.POLARISATIONS:
                    share = returned[polarisation][list(back).index(order)]
                    self.assertAlmostEqual(share, forth[polarisation][place], delta=1e-12)

    def test_small_slope_is_exact_for_shallow_gratings(self):
        for index in [1.5, ALUMINIUM]:
            for period, sine in [(0.9, 0.6), (1.5, 0.9), (3.0, -0.3)]:
                curve = sinusoid(period, 2e-3)
                rigorous = efficiencies(curve, sine, index, 31)
                found = scalar.predict("small-slope", curve, sine, index, rigorous.orders).shares
                first = abs(rigorous.orders) == 1
                for polarisation, share in rigorous.reflected.items():
                    error = abs(found[polarisation] / share - 1)[first]
                    self.assertLess(error.max(), 2e-3, (index, period, polarisation))

    def test_no_light_is_made(self):
        for curve in [sinusoid(0.8, 0.4), sinusoid(3, 0.8), blaze(1.5, 0.6)]:
            for index in [1.5, ALUMINIUM]:
                for sine in np.sin(np.radians([0, 30, 60, 80, -80, 89])):
                    orders = np.arange(-9, 10)
                    orders = orders[abs(sine + orders / curve.period) < 1]
                    total = scalar.shares("small-slope", curve, sine, index, orders)["mean"].sum()
                    flat = np.mean(scalar.fresnel(index, np.sqrt(1 - sine**2)))
                    self.assertLess(total, flat * (1 + 1e-12))


if __name__ == "__main__":
    unittest.main()
