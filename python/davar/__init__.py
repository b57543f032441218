"""Dynamic Allan variance: the microcontroller's C core with numpy arrays. See docs/PYTHON.md."""

from ._adev import Adev, adev
from ._read import Recording, read
from ._stream import Epochs, Stream, dynamic

__all__ = ["Adev", "Epochs", "Recording", "Stream", "adev", "dynamic", "read"]
