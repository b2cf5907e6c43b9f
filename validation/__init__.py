"""What only the project needs: how good estimates, health, diagnosis and grip are, also with faults."""
