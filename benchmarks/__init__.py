"""Speed, always as a ratio of two times measured in the same run.

Every module here without a leading underscore is a benchmark: its function ``run()`` returns
``{NAME: {"ours_us", "theirs_us", "ratio"}}``, the ratio being theirs over ours. ``vegrip bench`` finds
the modules by itself.
"""
