"""A whole step in one compiled call, for one environment or many: what they hold is arrays that kernels share."""
