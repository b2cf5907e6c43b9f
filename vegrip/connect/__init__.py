"""From a database and some traffic to a map: what ``vegrip connect`` guesses, proposes, asks and writes."""
