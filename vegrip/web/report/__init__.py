"""Reports: one file of HTML each, with everything in it, to read, to send on and to print."""
