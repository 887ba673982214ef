"""Snow profiles: reading what observers, models and penetrometers write; mechanics from it; stability; scenes."""
