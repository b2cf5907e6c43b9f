"""What a process needs of its machine: private folders, locks, sockets of the dead, open files."""
