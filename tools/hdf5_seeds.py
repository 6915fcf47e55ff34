#!/usr/bin/env python3
"""Writes small HDF5 files as JPK, Zygo and Nanosurf lay them out: the fuzzer's seeds, which the tests of the readers read.

By h5py, so by the HDF5 Group's own library: tools/hdf5_seeds.py, where `pip install h5py numpy` was run. Three samples wide, two rows
high; the numbers are those of src/surface/files/testing.rs.
"""

import pathlib

import h5py
import numpy as np

SEEDS = pathlib.Path(__file__).parents[1] / "fuzz" / "seeds"
TOP, BOTTOM = [1, 2, 3], [4, 5, 6]
TEXT = h5py.string_dtype()


def create(format, name, **settings):
    folder = SEEDS / format
    folder.mkdir(parents=True, exist_ok=True)
    return h5py.File(folder / name, "w", **settings)


def jpk():
    """Two frames of heights forwards, one of an error signal backwards; the first line is the lowest."""
    with create("jpk_hdf5", "frames.h5-jpk", track_order=True) as file:
        file.attrs["file-format-info"] = np.bytes_("JPK SCAN")
        measurement = file.create_group("Measurement_000")
        grid = {"ilength": np.int32(3), "jlength": np.int32(2), "ulength": 1.5e-6, "vlength": 2e-6, "reflect": np.bytes_("false")}
        for name, value in grid.items():
            measurement.attrs[f"position-pattern.grid.{name}"] = value
        channels = [("error", "Error Signal", "true", "Error", 1e-12, 0.0), ("height", "Height", "false", "Height", -1e-9, 1e-8)]
        for i, (name, shown, retrace, dataset, factor, offset) in enumerate(channels):
            channel = measurement.create_group(f"Channel_{i:03}")
            attributes = {"channel.name": name, "channel.fancy-name": shown, "retrace": retrace, "net-encoder.scaling.unit.unit": "m"}
            for key, value in attributes.items():
                channel.attrs[key] = np.bytes_(value)
            channel.attrs["net-encoder.scaling.multiplier"] = factor
            channel.attrs["net-encoder.scaling.offset"] = offset
            frames = np.array([BOTTOM + TOP, [7 + x for x in BOTTOM + TOP]], dtype="i4").T
            channel.create_dataset(dataset, data=frames, chunks=(6, 1), compression="gzip")
            channel.create_dataset("thumbnail", data=np.zeros((4, 1), dtype="i4"))


def zygo():
    """A map in metres with one sample that was not measured, and one in fringes."""
    converter = np.dtype([("Category", TEXT), ("BaseUnit", TEXT), ("Parameters", h5py.vlen_dtype(np.float64))])
    maps = [("metres", "Meters", [TOP, BOTTOM], 1e-9, 7.0), ("fringes", "Fringes", [TOP, BOTTOM], 1.0, 1e300)]
    for name, unit, rows, scale, no_data in maps:
        with create("zygo_hdf5", f"{name}.datx") as file:
            rows = np.array(rows) * scale
            if name == "metres":
                rows[1, 2] = no_data
            surface = file.create_dataset("Data/Surface/{0-1-2}", data=rows)
            attributes = {"No Data": no_data, "Wavelength": 6e-7, "Obliquity Factor": 1.1, "Interferometric Scale Factor": 0.5}
            for key, value in attributes.items():
                surface.attrs[key] = np.array([value])
            surface.attrs.create("Unit", [unit], dtype=TEXT)
            steps = [("X", "LateralCat", 5e-7), ("Y", "LateralCat", 1e-6), ("Z", "HeightCat", 0.0)]
            for axis, category, step in steps:
                row = np.array([(category, "Pixels", np.array([0.0, step, 0.0, 0.0]))], dtype=converter)
                surface.attrs.create(f"{axis} Converter", row, dtype=converter)
            file.create_dataset("Data/Intensity/{0-1-2}", data=np.zeros((2, 3), dtype="u2"))


def nanosurf():
    """Heights by both versions of the format; the first line is the lowest."""
    codes = np.array(BOTTOM + TOP, dtype="i4") * 1000
    with create("nanosurf_hdf5", "version_1.nhf") as file:
        file.attrs["nsf_file_version_major"] = np.int32(1)
        group = file.create_group("group_0000")
        sizes = {"image_points_per_line": np.int32(3), "image_number_of_lines": np.int32(2), "image_size_x": 1.5e-6, "image_size_y": 2e-6}
        for key, value in sizes.items():
            group.attrs[key] = value
        segment = group.create_group("subgroup_0000")
        segment.attrs["name"] = "Forward"
        dataset = segment.create_dataset("dataset_0000", data=codes)
        attributes = {"name": "Topography", "base_calibration_unit": "m", "base_calibration_min": -2.0**31 * 1e-12, "base_calibration_max": (2.0**31 - 1) * 1e-12, "dataset_element_type": np.int32(0)}
        for key, value in attributes.items():
            dataset.attrs[key] = value
    with create("nanosurf_hdf5", "version_2.nhf") as file:
        file.attrs["nsf_file_version_major"] = np.int32(2)
        group = file.create_group("group_0000")
        group.attrs["rect_axis_size"] = np.array([2, 3], dtype="i4")
        group.attrs["rect_axis_range"] = np.array([2e-6, 1.5e-6])
        for number, (name, sign) in enumerate([("Forward", 1), ("Backward", -1)]):
            segment = group.create_group(f"subgroup_{number:04}")
            segment.attrs["segment_name"] = name
            missing = np.int32(-(2**31))
            data = codes * sign
            if sign < 0:
                data[0] = missing
            dataset = segment.create_dataset("dataset_0000", data=data, fillvalue=missing)
            attributes = {"signal_name": "Position Z", "signal_calibration_unit": "m", "signal_calibration_min": -2.0**31 * 1e-12, "signal_calibration_max": (2.0**31 - 1) * 1e-12, "dataset_element_type": "dt_int32"}
            for key, value in attributes.items():
                dataset.attrs[key] = value
            segment.create_dataset("dataset_0001", data=np.zeros(2, dtype="u1"))  # without a signal


if __name__ == "__main__":
    jpk()
    zygo()
    nanosurf()
