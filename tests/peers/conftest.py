"""Settings of other packages, made before they are imported."""

import os

# On small networks, and beside other work, threads that wait for each other take many times as long as one.
os.environ.setdefault("OMP_NUM_THREADS", "1")
