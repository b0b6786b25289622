"""What a law gets wrong on measured data: which effect, how sure, what it costs, and the law extended by it."""
