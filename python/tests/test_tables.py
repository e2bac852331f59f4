"""Tables as arrays and datasets, against their definitions."""

from __future__ import annotations

import unittest
import warnings

import midair
import numpy as np
from common import Case

PAIR = midair.design("triangular-pair")


class Tables(Case):
    def test_eta_at_many_directions_is_that_at_each(self) -> None:
        table = midair.trace(
            PAIR, refractive_index=1.49, incidence="0:40:10", azimuth="full:15", bins=8
        )
        generator = np.random.default_rng(1)
        incidence = np.append(generator.uniform(0, 40, 40), [0, 20, 20, 40])
        azimuth = np.append(generator.uniform(-360, 360, 40), [0, 15, 22, 30])
        each = [table.eta_at(*place) for place in zip(incidence, azimuth)]
        # The same sums in another order.
        np.testing.assert_allclose(table._table.etas(incidence, azimuth), each, atol=1e-12)
        with self.assertRaises(midair._midair.Refusal):
            table._table.etas(np.array([10.0, 41.0]), np.array([0.0, 0.0]))
        self.tell(len(each), "directions")

    def test_polygons_give_eta_and_the_transfer_function(self) -> None:
        table = midair.trace(PAIR, refractive_index=1.49, incidence="0:40:20", azimuth=[0, 30])
        cases = 0
        for incidence in (0.0, 20.0, 31.0):
            for azimuth in (0.0, 30.0):
                paths = table.polygons(incidence, azimuth)
                power = np.array([path.weight * path.area for path in paths])
                _, entrance = table._paths(incidence, azimuth)
                self.assertAlmostEqual(
                    power.sum() / entrance, table.eta_at(incidence, azimuth), delta=1e-12
                )
                # The transfer function by the midpoint rule: each polygon is cut into triangles,
                # and each triangle into 60^2 equal ones. The error of the rule is f^2 area / 12
                # times (2 pi)^2 for the smallest triangles: 2e-4 at most.
                f = np.array([[0.0, 0.0], [0.3, 0.1], [-0.2, 0.5], [0.0, 1.0]])
                direct = sum(by_midpoints(path, f) for path in paths) / power.sum()
                made = table.otf(f[:, 0], f[:, 1], incidence, azimuth)
                np.testing.assert_allclose(made, direct, atol=2e-4)
                self.assertAlmostEqual(made[0].real, 1.0, delta=1e-14)
                cases += 1
        grid = table.otf(np.linspace(0, 1, 5)[:, None], np.linspace(0, 1, 3), 20, 30)
        self.assertEqual(grid.shape, (5, 3))
        mm = table.otf(2.0, 0.0, 20, 30, c_mm=0.25)
        np.testing.assert_allclose(mm, table.otf(0.5, 0.0, 20, 30), rtol=1e-14)
        self.tell(cases, "directions")

    def test_samples_have_the_transfer_function_of_the_table(self) -> None:
        n, cases = 100_000, 0
        exact = midair.trace(PAIR, refractive_index=1.49, incidence=20, azimuth=30)
        rays = midair.trace(
            PAIR, refractive_index=1.49, incidence=20, azimuth=30, method="rays", rays=1 << 20
        )
        for table in (exact, rays):
            drawn = table.sample(n, 3, 20)
            self.assertEqual(drawn.shape, (n, 2))
            np.testing.assert_array_equal(drawn, table.sample(n, 3, 20))
            for f in ([0.3, 0.0], [0.0, 0.4], [0.5, -0.2]):
                mean = np.exp(-2j * np.pi * (drawn @ np.array(f))).mean()
                truth = complex(table.otf(*f, 20))
                # Real and imaginary part each err by less than 1 / sqrt(n): 5 of these, in 12
                # comparisons, fail once in 10^5 runs.
                self.assertLess(abs((mean - truth).real), 5 / np.sqrt(n))
                self.assertLess(abs((mean - truth).imag), 5 / np.sqrt(n))
                cases += 1
        self.tell(cases, "frequencies")

    def test_the_nearest_azimuth_is_found_in_a_folded_table(self) -> None:
        table = midair.trace(PAIR, refractive_index=1.49, incidence=[0, 35], azimuth="full:10")
        folded = table.to_xarray(unfold=False)
        data = table.to_xarray()
        self.assertLess(len(folded.azimuth_deg), len(data.azimuth_deg))
        self.assertEqual(float(data.azimuth_deg[-1]), 360.0)
        cases = 0
        for azimuth in range(0, 360, 10):
            alone = midair.trace(PAIR, refractive_index=1.49, incidence=[0, 35], azimuth=azimuth)
            found = data.sel(azimuth_deg=azimuth, method="nearest")
            self.assertEqual(float(found.azimuth_deg), azimuth)
            np.testing.assert_allclose(found.retroreflected, alone.eta[:, 0], atol=1e-13)
            np.testing.assert_allclose(found.histogram, alone.histogram[:, 0], atol=1e-12)
            cases += 1
        self.tell(cases, "azimuths")

    def test_datasets_have_names_and_units(self) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            mean = midair.trace(PAIR, incidence=[0, 20], azimuth="mean").to_xarray()
        self.assertNotIn("azimuth_deg", mean.dims)
        data = midair.trace(PAIR, refractive_index=1.49, incidence=[0, 20], azimuth=30).to_xarray()
        self.assertEqual(data.attrs["Conventions"][:3], "CF-")
        for name, variable in data.variables.items():
            if name != "fate_name":
                self.assertIn("units", variable.attrs, name)
            self.assertIn("long_name", variable.attrs, name)
        # It is a file that netCDF reads.
        data.to_netcdf(self.folder / "data.nc", engine="h5netcdf")
        self.tell(len(data.variables), "variables")

    def test_directions_outside_are_refused(self) -> None:
        table = midair.trace(PAIR, refractive_index=1.49, incidence=[0, 20], azimuth=30)
        for call in (
            lambda: table.eta_at(30),
            lambda: table.polygons(10, 60),
            lambda: table.otf(0.1, 0, 89.0),
            lambda: table.sample(3, 1, 50),
        ):
            with self.assertRaises(midair.Error) as caught:
                call()
            self.assertIn("the nearest direction in it is", caught.exception.sentence)
        with self.assertRaises(midair.Error):
            midair.trace(
                PAIR, refractive_index=1.49, method="rays", rays=1000, incidence=0
            ).polygons(0)


def by_midpoints(path: midair.Path, f: np.ndarray, parts: int = 60) -> np.ndarray:
    """Return the integral of exp(-2 pi i f s) over a path's polygon, times its weight."""
    first = path.polygon[0]
    total = np.zeros(len(f), complex)
    steps = np.arange(parts)
    i, j = (grid.ravel() for grid in np.meshgrid(steps, steps))
    up = i + j < parts
    down = i + j < parts - 1
    a = np.concatenate([i[up] + 1 / 3, i[down] + 2 / 3]) / parts
    b = np.concatenate([j[up] + 1 / 3, j[down] + 2 / 3]) / parts
    for second, third in zip(path.polygon[1:], path.polygon[2:]):
        side, other = second - first, third - first
        area = 0.5 * (side[0] * other[1] - side[1] * other[0])
        points = first + a[:, None] * side + b[:, None] * other
        phases = np.exp(-2j * np.pi * path.shift(points) @ f.T)
        total += path.weight * area * phases.mean(axis=0)
    return total


if __name__ == "__main__":
    unittest.main()
