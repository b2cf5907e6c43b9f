"""The bus without errors as text that also C runs: arbitration, frame times, deliveries, over flat memory."""
