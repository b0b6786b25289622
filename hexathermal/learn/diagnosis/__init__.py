"""What a law gets wrong on measured data: which effect, how sure, what it costs, and the law extended by it.

`diagnose` is the way in. The method stands in docs/diagnosis.md.
"""

from hexathermal.learn.diagnosis.diagnosing import diagnose
from hexathermal.learn.diagnosis.result import Diagnosis

__all__ = ["Diagnosis", "diagnose"]
