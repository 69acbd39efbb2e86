"""Claims about whole worlds: scenes, friction, joints, sleep, the paper's rules."""
