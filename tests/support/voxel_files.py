"""Voxel images in every format that is read."""

import numpy as np
from PIL import Image


def write(voxels, path):
    """The same image in the format that the ending names."""
    if path.suffix == ".npy":
        np.save(path, voxels)
    elif path.suffix == ".npz":
        np.savez_compressed(path, phase=voxels)
    elif path.suffix == ".raw":
        path.write_bytes(voxels.tobytes(order="F"))
    elif path.suffix in (".mhd", ".mha"):
        write_metaimage(voxels, path)
    elif voxels.ndim == 2:
        Image.fromarray(voxels.T[::-1]).save(path)
    else:
        pages = [Image.fromarray(page) for page in voxels.T]
        pages[0].save(path, save_all=True, append_images=pages[1:])
    return path


def write_metaimage(voxels, path, **keys):
    """A header, and the voxels after 3 bytes of another file or, of .mha, after it."""
    local = path.suffix == ".mha"
    lines = {"ObjectType": "Image", "NDims": voxels.ndim, "DimSize": " ".join(map(str, voxels.shape)),
             "ElementType": {"u1": "MET_UCHAR", "i2": "MET_SHORT"}[voxels.dtype.str[1:]],
             "BinaryDataByteOrderMSB": voxels.dtype.str[0] == ">", "HeaderSize": 0 if local else 3, **keys,
             "ElementDataFile": "LOCAL" if local else keys.get("ElementDataFile", f"{path.stem}_voxels.raw")}
    header = "".join(f"{key} = {value}\n" for key, value in lines.items()).encode()
    body = voxels.tobytes(order="F")
    path.write_bytes(header + body if local else header)
    path.with_name(f"{path.stem}_voxels.raw").write_bytes(b"abc" + body)
    return path
