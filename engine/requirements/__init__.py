"""What of a scene has to be modelled for an asked error, decided with a bound for everything that is left out."""
