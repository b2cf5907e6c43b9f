"""Speed, always as a ratio of two times measured in the same run.

Every module here has a function ``run()`` that returns ``{NAME: {"ours_us", "theirs_us", "ratio"}}``, the ratio being
theirs over ours. ``vegrip bench`` finds the modules by itself.
"""
