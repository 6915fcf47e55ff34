"""Prints the errors of orders of a blaze by the width of its flanks, as docs/VALIDITY.md has them. `python flanks.py`."""

import grid
import scalar
from profiles import blaze

# Period and height [wavelengths], and widths of the flanks over the period.
PERIOD, HEIGHT, FLANKS = 6.0, 0.3, [0.2, 0.06, 0.03, 0.015]
ORDERS = [-1, 0, 1]


def main():
    for material, index in grid.MATERIALS.items():
        for flank in FLANKS:
            curve = blaze(PERIOD, HEIGHT, flank)
            solved = grid.solve(curve, 0.0, index, grid.TOLERANCE)
            if solved is None:
                print(f"{material}, flanks of {flank}: does not settle")
                continue
            found, _ = solved
            predicted = scalar.shares("small-slope", curve, 0.0, index, found.order)
            error = abs(predicted["mean"] / found.rigorous["mean"] - 1)
            errors = " / ".join(f"{100 * error[found.order == order][0]:.2g}" for order in ORDERS)
            print(f"{material}, flanks of {flank}: {errors} %")


if __name__ == "__main__":
    main()
