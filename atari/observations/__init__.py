"""From frames to observations, for every core: settings of the C++ pipeline, axes and dtype."""
