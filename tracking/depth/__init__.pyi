from .cameras import DepthCamera as DepthCamera
from .cameras import register_depth as register_depth
from .edges import EdgeOffset as EdgeOffset
from .edges import edge_offset as edge_offset
from .lattice import inverse_depth_step as inverse_depth_step
from .refine import RefinedByDepth as RefinedByDepth
from .refine import refine_by_depth as refine_by_depth
