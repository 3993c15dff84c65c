"""Pictures of truth and belief, drawn with Pillow alone; imported only when somebody looks."""

from regionslam_env.rendering.animation import GifWriter
from regionslam_env.rendering.map_picture import draw_map, draw_truth
from regionslam_env.rendering.mission_picture import Stop, draw_mission
from regionslam_env.rendering.renderer import Renderer, Snapshot

__all__ = ["GifWriter", "Renderer", "Snapshot", "Stop", "draw_map", "draw_mission", "draw_truth"]
