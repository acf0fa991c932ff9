"""`python -m modelgen` is `modelgen`."""

import sys

from modelgen.cli import main

sys.exit(main())
