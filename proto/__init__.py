"""The contract with the outside: CAN database, object dictionary, message schema and topic table."""
