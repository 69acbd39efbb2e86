"""Bodies as files for other programs: a moment as PLY, OBJ, GLB or USD, a trajectory as many, or as one that moves."""

from softbody.export.files import export_film, export_moment, export_sequence

__all__ = ["export_film", "export_moment", "export_sequence"]
