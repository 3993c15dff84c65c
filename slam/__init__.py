"""Region-based FastSLAM 2.0 (Oberländer et al. 2008) as a library of its own."""
