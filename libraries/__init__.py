"""Data that ships with Lumenray and that users extend, and the small readers that find it."""
