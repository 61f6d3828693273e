"""The REST interface and the stream, one router for each noun."""
