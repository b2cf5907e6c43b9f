"""The grasp force node: fingertip states in, slip margins and force commands out; pure code, no bus."""
