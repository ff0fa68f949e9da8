"""Settings of other packages, made before they are imported."""

import os

# For small networks on a busy machine, several threads take many times as long as one.
os.environ.setdefault("OMP_NUM_THREADS", "1")
