"""A pair in the Rerun viewer."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from . import Sample


def points(sample: Sample) -> tuple[Any, Any]:
    """Where the left view's pixels lie in the world, m (n, 3), and which pixels those are (rows, columns) bool.

    Middlebury's formula, depth = f B / (d + doffs), in the left camera; pixel centres stand at integers.
    """
    import numpy as np

    left = sample.camera["left"]
    known = np.isfinite(sample.disparity)
    v, u = np.nonzero(known)
    depth_m = left["fx_px"] * sample.camera["baseline_m"] / (sample.disparity[known].astype(np.float64) + sample.camera["doffs_px"])
    seen = np.stack([(u - left["cx_px"]) / left["fx_px"], (v - left["cy_px"]) / left["fy_px"], np.ones_like(depth_m)], axis=1)
    return seen * depth_m[:, None] @ np.asarray(left["world_from_camera"]).T + left["position_m"], known


def view(sample: Sample, *, save: str | os.PathLike[str] | None, name: str) -> Any:
    """What `satseed.view` does."""
    from . import Sample

    if not isinstance(sample, Sample):
        raise TypeError(f"view shows a satseed.Sample, such as satseed.generate() makes, but {sample!r} is none")
    try:
        import rerun as rr
    except ImportError as e:
        raise ImportError("satseed.view needs Rerun: pip install rerun-sdk") from e
    import numpy as np

    if save is not None and not os.path.isdir(os.path.dirname(os.path.abspath(save))):
        raise FileNotFoundError(f"{os.fspath(save)} cannot be written, since its folder does not exist")
    recording = rr.RecordingStream(name)
    if save is None:
        recording.spawn()
    else:
        recording.save(os.fspath(save))
    recording.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    for side, image in (("left", sample.left), ("right", sample.right)):
        camera = sample.camera[side]
        place = rr.Transform3D(translation=camera["position_m"], mat3x3=np.asarray(camera["world_from_camera"]))
        recording.log(f"world/{side}", place)
        lens = rr.Pinhole(
            focal_length=[camera["fx_px"], camera["fy_px"]],
            # Rerun's pixels begin at integers.
            principal_point=[camera["cx_px"] + 0.5, camera["cy_px"] + 0.5],
            resolution=[camera["width_px"], camera["height_px"]],
            camera_xyz=rr.ViewCoordinates.RDF,
            image_plane_distance=0.25 * sample.camera["altitude_m"],
        )
        recording.log(f"world/{side}/image", lens, rr.Image(_shown(image)))
    recording.log("disparity_px", rr.Image(sample.disparity))
    names = [(0, "nothing hit"), (1, "valid"), (2, "occluded"), (3, "out of frame")]
    recording.log("validity", rr.AnnotationContext(names), static=True)
    recording.log("validity", rr.SegmentationImage(sample.validity))
    where, known = points(sample)
    shown = _shown(sample.left)
    colours = shown[known] if shown.ndim == 3 else np.repeat(shown[known][:, None], 3, axis=1)
    recording.log("world/points", rr.Points3D(where, colors=colours, radii=0.5 * sample.camera["gsd_m"]))
    facts = f"{sample.id}: baseline {sample.baseline_m} m, azimuth {sample.azimuth_deg} degrees, {sample.split}"
    recording.log("sample", rr.TextDocument(facts))
    recording.flush()
    return recording


def _shown(image: Any) -> Any:
    """An image as 8 bits of one band or three: counts and radiance from their darkest to their brightest."""
    import numpy as np

    image = image[..., :3] if image.ndim == 3 and image.shape[2] > 3 else image
    if image.dtype == np.uint8:
        return image
    low, high = np.percentile(image, [0.5, 99.5])
    return (np.clip((image.astype(np.float64) - low) / max(high - low, 1e-12), 0, 1) * 255).astype(np.uint8)
