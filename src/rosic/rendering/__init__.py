"""Drawing: frames made smaller, maps, charts, ways and scenes. Values in, bytes out; no I/O.

The only home of Pillow. What comes from a robot is checked before it is opened, and how much work
a picture may cause is bounded: `rosic.rendering.draw.draw` is the only way in.
"""

from __future__ import annotations
