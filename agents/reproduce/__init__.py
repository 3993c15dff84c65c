"""The experiments of Oberländer et al. 2008, repeated with this filter."""
