"""Reads Pleat's dataset.h5 (docs/dataset.md). Needs numpy and h5py.

    from pleat_dataset import PleatDataset
    data = PleatDataset("dataset.h5", split="train")
    item = data[0]   # also through torch.utils.data.DataLoader(data, batch_size=8, shuffle=True, num_workers=2)
"""
import h5py
import numpy as np

SPLITS = {"train": 0, "held_out_design": 1, "held_out_sequence": 2, "held_out_both": 3}


class PleatDataset:
    """Rows of one split (None: all), each a dict of float32 arrays:
    texture [3, R, R], pose [72] (axis-angle, rad), shape [S], design [3] (length, sleeve, cleavage), and
    previous_texture [3, R, R] where `with_previous`, NaN where there is none; and `row`, its number in the file.
    Textures are offsets from the design's template, m; with `normalised`, (offset - mean) / std inside the mask.
    """

    def __init__(self, path, split="train", normalised=False, with_previous=False):
        self.path, self.normalised, self.with_previous = path, normalised, with_previous
        self._file = None  # opened by each process for itself: h5py does not survive a fork
        with h5py.File(path, "r") as f:
            in_split = f["split"][:] == SPLITS[split] if split else np.ones(len(f["split"]), bool)
            self.rows = np.flatnonzero(in_split)
            self.scale = np.float32(f["textures"].attrs["scale_m"])
            self.mask = f["mask"][:] > 0
            self.mean = f["normalisation/mean"][:].reshape(3, 1, 1)
            self.std = f["normalisation/std"][:].reshape(3, 1, 1)
            self.pose = f["pose"][:].reshape(-1, 72)
            self.shape = f["shape"][:]
            self.design = f["designs/parameters"][:][f["design_index"][:]]
            self.previous = f["previous"][:]

    def __len__(self):
        return len(self.rows)

    def texture(self, row):
        """Of a row of the file, whatever its split."""
        if self._file is None:
            self._file = h5py.File(self.path, "r")
        offsets = self._file["textures"][row] * self.scale
        return (offsets - self.mean) / self.std * self.mask if self.normalised else offsets

    def __getitem__(self, index):
        row = int(self.rows[index])
        item = {"texture": self.texture(row), "pose": self.pose[row], "shape": self.shape[row],
                "design": self.design[row], "row": row}
        if self.with_previous:
            before = int(self.previous[row])
            item["previous_texture"] = self.texture(before) if before >= 0 else np.full_like(item["texture"], np.nan)
        return item

    def __getstate__(self):
        return {**self.__dict__, "_file": None}
