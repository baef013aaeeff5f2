"""The commands ``lumenray paint``: effect paints from their composition."""
