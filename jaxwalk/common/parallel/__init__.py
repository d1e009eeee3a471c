"""Several devices and several processes: how walkers are spread over them, and how these agree."""
