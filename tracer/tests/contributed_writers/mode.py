"""Writes a trace under a mask, which nothing may change meanwhile, and says the file's mode: mode.py FILE.rbt"""

import os
import sys

from one_ray import begin, filled

path = sys.argv[1]
os.umask(0o027)
del os.umask
with begin(path) as writer:
    writer.write_tile(filled(writer))
    writer.finish()
print(oct(os.stat(path).st_mode & 0o777))
