"""How often davarlab is right on recordings that its own simulator did not make (elsewhere.py),
beside a model of N and B as they are:

PYTHONPATH=tools/lab build/venv-lab/bin/python tests/lab/benchmark_elsewhere.py
    FIRST_SEED SEEDS [CASE ...]
"""

import benchmark_awkward

if __name__ == "__main__":
    benchmark_awkward.main("elsewhere", __doc__)
